#include "vir/evaluation/leaps.h"

#include <algorithm>
#include <cmath>

#include "vir/core/order_statistics.h"
#include "vir/core/time_bounds.h"
#include "vir/geometry/finite_pose.h"

namespace vir::evaluation {
namespace {

constexpr double kLeastLeapM = 1, kLeastLeapMps = 100, kTimesAround = 20;
/// Steps before and after one that tell what is usual there.
constexpr std::size_t kAround = 5;

double distance(const StampedPose& a, const StampedPose& b) {
  return (b.T_W_B.p - a.T_W_B.p).stableNorm();
}

double seconds(const StampedPose& a, const StampedPose& b) {
  return toSeconds(timeBetween(a.t, b.t));
}

/// Per step, the fastest that is no leap there [m/s].
std::vector<double> limits(const Trajectory& poses) {
  std::vector<double> speed;
  for (std::size_t i = 0; i + 1 < poses.size(); ++i) {
    const double dt = std::max(1e-9, seconds(poses[i], poses[i + 1]));
    speed.push_back(distance(poses[i], poses[i + 1]) / dt);
  }
  std::vector<double> out;
  for (std::size_t i = 0; i < speed.size(); ++i) {
    std::vector<double> around;
    for (std::size_t k = i - std::min(i, kAround); k < std::min(speed.size(), i + kAround + 1); ++k)
      if (k != i) around.push_back(speed[k]);
    out.push_back(std::max(kLeastLeapMps, kTimesAround * medianInPlace(&around)));
  }
  return out;
}

bool leaps(const StampedPose& a, const StampedPose& b, double limit_mps) {
  const double d = distance(a, b);
  return !(d <= kLeastLeapM || d <= limit_mps * seconds(a, b));
}

struct Piece {
  std::size_t begin = 0, end = 0;
  std::size_t size() const { return end - begin; }
};

std::vector<Piece> piecesOf(const Trajectory& poses, const std::vector<double>& limit) {
  std::vector<Piece> out{{0, 1}};
  for (std::size_t i = 1; i < poses.size(); ++i) {
    if (leaps(poses[i - 1], poses[i], limit[i - 1])) out.push_back({i, i});
    out.back().end = i + 1;
  }
  return out;
}

}  // namespace

Trajectory withoutLeaps(const Trajectory& trajectory, long* left_out) {
  Trajectory poses;
  std::copy_if(trajectory.begin(), trajectory.end(), std::back_inserter(poses),
               [](const StampedPose& pose) { return isFinite(pose.T_W_B); });
  Trajectory out;
  if (!poses.empty()) {
    const std::vector<double> limit = limits(poses);
    const std::vector<Piece> pieces = piecesOf(poses, limit);
    const auto longest =
        std::max_element(pieces.begin(), pieces.end(),
                         [](const Piece& a, const Piece& b) { return a.size() < b.size(); });
    std::vector<Piece> kept{*longest};
    for (auto p = longest; p != pieces.begin();) {
      --p;
      const std::size_t next = kept.back().begin;
      if (!leaps(poses[p->end - 1], poses[next], limit[p->end - 1])) kept.push_back(*p);
    }
    std::reverse(kept.begin(), kept.end());
    for (auto p = longest + 1; p != pieces.end(); ++p) {
      const std::size_t last = kept.back().end - 1;
      if (!leaps(poses[last], poses[p->begin], limit[p->begin - 1])) kept.push_back(*p);
    }
    for (const Piece& p : kept) {
      const auto at = [&](std::size_t i) { return poses.begin() + static_cast<long>(i); };
      out.insert(out.end(), at(p.begin), at(p.end));
    }
  }
  if (left_out != nullptr) *left_out = static_cast<long>(trajectory.size() - out.size());
  return out;
}

std::string describeLeaps(long left_out) {
  return std::to_string(left_out) + (left_out == 1 ? " pose" : " poses") +
         " of the reference left out: where it says, nothing can have been (faster than 100 m/s, "
         "and "
         "20 times as fast as before and after)";
}

}  // namespace vir::evaluation
