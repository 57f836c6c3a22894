#include "vir/simulation/simulate_ranges.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "vir/core/random.h"
#include "vir/simulation/interval.h"

namespace vir {
namespace {

void checkLists(const RangeSimulationOptions& o) {
  const auto refuse = [](const std::string& what) {
    throw std::invalid_argument("simulateRanges: " + what);
  };
  if (o.anchor_m.size() % 3 != 0) refuse("anchor_m must hold 3 numbers per anchor");
  if (!o.anchor_id.empty() && o.anchor_id.size() != o.anchor_m.size() / 3) {
    refuse("anchor_id must hold one number per anchor");
  }
  if (o.lever_arm_m.size() != 3) refuse("lever_arm_m must hold 3 numbers");
  if (o.bias_curve.size() % 2 != 0) refuse("bias_curve must hold pairs (distance, bias)");
  if (o.jump.size() % 5 != 0) refuse("jump must hold 5 numbers (index, time, x, y, z) per jump");
  if (!(o.rate_hz > 0)) refuse("rate_hz must be positive");
}

double curve(const std::vector<double>& points, double x) {
  if (points.empty()) return 0;
  if (x <= points[0]) return points[1];
  for (std::size_t k = 2; k < points.size(); k += 2) {
    if (x > points[k]) continue;
    const double s = (x - points[k - 2]) / (points[k] - points[k - 2]);
    return points[k - 1] + s * (points[k + 1] - points[k - 1]);
  }
  return points.back();
}

/// What changes slowly at one anchor: the correlated error, and whether something stands in the
/// way.
class Channel {
 public:
  Channel(const RangeSimulationOptions& o, std::uint64_t index)
      : o_(o), random_(static_cast<std::uint64_t>(o.seed), 200 + index) {}

  double jitter() { return o_.jitter * random_.uniform(-1, 1); }

  /// Draws the same number of random numbers whatever the settings.
  SimulatedRange measure(double true_m, double dt) {
    const double white = random_.normal(), innovation = random_.normal();
    const double block = random_.uniform(), length = random_.uniform(), lost = random_.uniform();
    const double keep = started_ ? std::exp(-dt / o_.correlated_s) : 0;
    correlated_ = keep * correlated_ + std::sqrt(1 - keep * keep) * innovation;
    updateBlocked(dt, block, length);
    started_ = true;
    SimulatedRange r;
    r.true_m = true_m;
    r.line_of_sight = !blocked_;
    r.range_m =
        std::max(0.0, true_m + o_.bias_m + curve(o_.bias_curve, true_m) + o_.sigma_m * white +
                          o_.correlated_sigma_m * correlated_ + (blocked_ ? excess_ : 0));
    dropped_ = lost < o_.dropped_share;
    return r;
  }
  bool dropped() const { return dropped_; }

 private:
  void updateBlocked(double dt, double block, double length) {
    const double excess = o_.nlos_min_m + (o_.nlos_max_m - o_.nlos_min_m) * length;
    if (o_.nlos_burst_s <= 0) {
      blocked_ = block < o_.nlos_share;
      excess_ = excess;
      return;
    }
    // Two states whose mean stays keep the share; the excess belongs to the obstacle.
    const double share = std::min(o_.nlos_share, 0.999);
    const double free_s = o_.nlos_burst_s * (1 - share) / std::max(share, 1e-9);
    const double leave =
        started_ ? 1 - std::exp(-dt / (blocked_ ? o_.nlos_burst_s : free_s)) : share;
    if (block >= leave) return;
    blocked_ = !blocked_;
    if (blocked_) excess_ = excess;
  }

  const RangeSimulationOptions& o_;
  Random random_;
  double correlated_ = 0, excess_ = 0;
  bool blocked_ = false, dropped_ = false, started_ = false;
};

}  // namespace

Vec3 anchorAt(const RangeSimulationOptions& o, std::size_t index, double s) {
  Vec3 p(o.anchor_m.at(3 * index), o.anchor_m.at(3 * index + 1), o.anchor_m.at(3 * index + 2));
  for (std::size_t k = 0; k + 5 <= o.jump.size(); k += 5) {
    if (o.jump[k] == static_cast<double>(index) && s >= o.jump[k + 1]) {
      p = Vec3(o.jump[k + 2], o.jump[k + 3], o.jump[k + 4]);
    }
  }
  return p;
}

std::vector<SimulatedRange> simulateRanges(const Motion& motion, const RangeSimulationOptions& o) {
  checkLists(o);
  const Vec3 lever(o.lever_arm_m[0], o.lever_arm_m[1], o.lever_arm_m[2]);
  const double period = 1 / o.rate_hz;
  std::vector<SimulatedRange> out;
  for (std::size_t a = 0; 3 * a < o.anchor_m.size(); ++a) {
    Channel channel(o, a);
    double last = 0;
    for (int slot = 0;; ++slot) {
      // Half a period of offset: a negative jitter must not reach before the first pose.
      const double s = (slot + 0.5 + channel.jitter()) * period;
      const TimeNs t = motion.begin() + fromSeconds(s);
      if (t > motion.end()) break;
      const double truth = (motion.poseAt(t) * lever - anchorAt(o, a, s)).norm();
      SimulatedRange r = channel.measure(truth, s - last);
      last = s;
      r.t = t;
      r.anchor = o.anchor_id.empty() ? static_cast<int>(a) : static_cast<int>(o.anchor_id[a]);
      if (channel.dropped() || truth > o.max_distance_m || insideAny(o.outage_s, s)) continue;
      out.push_back(r);
    }
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const SimulatedRange& x, const SimulatedRange& y) { return x.t < y.t; });
  return out;
}

}  // namespace vir
