#include "vir/check/imu_clipping.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "text.h"

namespace vir::check {
namespace {

constexpr double kNear = 0.03;  // share of the limit
constexpr std::size_t kPassed = 40, kFollowed = 64;
constexpr long kFewest = 20;
/// Times as often as any other number near it. A smooth motion that reverses there has 2.4, if it
/// is always the same and the numbers are as coarse as kPassed allows; noise has less than 1.
constexpr long kPiledUp = 3;

}  // namespace

void ImuClipping::End::add(double size) {
  if (size > limit) {
    // What was the limit is one of those on the way now.
    if (limit > 0) near[limit] = at;
    if (limit > 0 && passed.size() < kPassed) passed.insert(limit);
    limit = size;
    at = again = 0;
    last_at = false;
    near.erase(near.begin(), near.lower_bound((1 - kNear) * limit));
    passed.erase(passed.begin(), passed.lower_bound(limit / 2));
  }
  const bool here = size == limit && size > 0;
  at += here ? 1 : 0;
  again += here && last_at ? 1 : 0;
  last_at = here;
  if (here || size <= limit / 2) return;
  if (passed.size() < kPassed) passed.insert(size);
  if (size < (1 - kNear) * limit) return;
  const auto known = near.find(size);
  if (known != near.end()) {
    ++known->second;
  } else if (near.size() < kFollowed) {
    near[size] = 1;
  }
}

long ImuClipping::End::mostNear() const {
  long out = 0;
  for (const auto& [value, count] : near) out = std::max(out, count);
  return out;
}

bool ImuClipping::End::clipped() const {
  // Many different numbers up to the limit: neither a coarse sensor nor one that says two values.
  return at >= kFewest && again >= at / 2 && passed.size() >= kPassed && at > kPiledUp * mostNear();
}

void ImuClipping::add(const ImuSample& s) {
  ++count_;
  for (std::size_t i = 0; i < 6; ++i) {
    const auto axis = static_cast<Eigen::Index>(i % 3);
    const double value = i < 3 ? s.gyro[axis] : s.acc[axis];
    ends_[i][value > 0 ? 1 : 0].add(std::abs(value));
    ends_[i][value > 0 ? 0 : 1].last_at = false;
  }
}

std::optional<Finding> ImuClipping::finding(Sensor sensor, const std::string& label,
                                            const std::string& unit) const {
  const bool gyro = sensor == Sensor::gyro;
  std::string limits, shares;
  const auto percent = [&](long n) {
    return num(100 * static_cast<double>(n) / static_cast<double>(count_), 2) + " %";
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto& [below, above] = ends_[axis + (gyro ? 0 : 3)];
    if (!below.clipped() && !above.clipped()) continue;
    // Where one end is reached often, the other may be so too seldom to tell by itself.
    const bool both =
        below.at > 1 && above.at > 1 && std::abs(below.limit - above.limit) < 0.001 * above.limit;
    const End& end = above.clipped() ? above : below;
    const char* sign = both ? "+-" : above.clipped() ? "" : "-";
    const std::string name = std::string(limits.empty() ? "" : ", ") + "xyz"[axis];
    limits += name + " at " + sign + num(end.limit);
    shares += name + " " + percent(both ? below.at + above.at : end.at) +
              " of all readings are just this number, of others near it none more than " +
              percent(std::max(below.clipped() ? below.mostNear() : 0, end.mostNear()));
  }
  if (limits.empty()) return std::nullopt;
  return Finding{Severity::doubtful,
                 gyro ? "gyro_clipped" : "acc_clipped",
                 label,
                 std::string("the ") + (gyro ? "gyro" : "accelerometer") +
                     " is clipped: " + limits + " " + unit,
                 shares,
                 "set a larger range in the IMU's driver, or look for what limits it on the way (a "
                 "filter, a type too small for the number)"};
}

}  // namespace vir::check
