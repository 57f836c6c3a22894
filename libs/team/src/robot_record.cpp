#include "vir/team/robot_record.h"

#include <algorithm>
#include <cmath>

#include "vir/geometry/finite_pose.h"
#include "vir/geometry/interpolation.h"
#include "vir/types/interpolation.h"

namespace vir::team {
namespace {

constexpr TimeNs kSnapshotEvery = 200000000;
constexpr TimeNs kLongestGap = 500000000;
constexpr double kSameRange = 1e-4;  // [m]; recordings keep ranges as float
constexpr double kNearMirror = 1.0;  // [m] sideways; closer, they are one anchor

}  // namespace

bool isSameRange(TimeNs t, double range_m, TimeNs other_t, double other_range_m) {
  return std::abs(t - other_t) <= kSameStamp && std::abs(range_m - other_range_m) < kSameRange;
}

bool keepPose(const StateEstimate& e, std::vector<KnownPose>* poses) {
  if (!e.valid || !isFinite(e.state.T_W_B)) {
    return false;
  }
  if (!poses->empty() && e.state.t <= poses->back().t) return false;
  poses->push_back({e.state.t, e.state.T_W_B, e.covariance, e.segment});
  return true;
}

std::optional<KnownPose> poseAt(const std::vector<KnownPose>& poses, TimeNs t) {
  const auto around = neighboursAt(poses, t, kLongestGap);
  if (!around) return std::nullopt;
  if (around->before == around->next) return *around->next;
  if (around->before->segment != around->next->segment) return std::nullopt;
  KnownPose out = *around->before;
  out.t = t;
  out.T_W_B = interpolate(around->before->T_W_B, around->next->T_W_B, around->s);
  return out;
}

std::optional<SentPosition> believed(const Anchor& a) {
  if (!a.has_position || !a.p_W.allFinite() || !a.covariance.allFinite()) return std::nullopt;
  Vec3 p_W = a.p_W;
  switch (a.state) {
    case AnchorState::estimated:
    case AnchorState::fixed:
      break;
    case AnchorState::mirror_open:
      // One above the other, as motion in a plane leaves them, both are in the same place but for
      // a height that nobody knows: their middle, which the covariance spans them from.
      if (!((a.mirror_p_W - a.p_W).head<2>().norm() < kNearMirror)) return std::nullopt;
      p_W = 0.5 * (a.p_W + a.mirror_p_W);
      if (!p_W.allFinite()) return std::nullopt;
      break;
    case AnchorState::collecting:
    case AnchorState::moved:
      return std::nullopt;
  }
  return SentPosition{0, p_W, a.covariance};
}

int robotOf(const Range& peer_range) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(peer_range.anchor));
}

const std::vector<Anchor>& RobotRecord::anchorsAt(TimeNs t) const {
  static const std::vector<Anchor> kNone;
  const auto next =
      std::upper_bound(anchors.begin(), anchors.end(), t,
                       [](TimeNs stamp, const AnchorSnapshot& s) { return stamp < s.t; });
  return next == anchors.begin() ? kNone : (next - 1)->anchors;
}

bool RobotRecord::snapshotDue() const {
  if (poses.empty()) return false;
  return anchors.empty() || poses.back().t >= anchors.back().t + kSnapshotEvery;
}

std::optional<Vec3> RobotRecord::antenna() const {
  if (!peer_ranges.empty()) return peer_ranges.front().p_B_U;
  if (!anchor_ranges.empty()) return anchor_ranges.front().p_B_U;
  return std::nullopt;
}

}  // namespace vir::team
