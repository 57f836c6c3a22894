#include "vir/types/interpolation.h"

#include "vir/geometry/interpolation.h"

namespace vir {
inline namespace types {

std::optional<Pose> poseAt(const Trajectory& path, TimeNs t, TimeNs longest_gap) {
  const auto around = neighboursAt(path, t, longest_gap);
  if (!around) return std::nullopt;
  if (around->before == around->next) return around->next->T_W_B;
  return interpolate(around->before->T_W_B, around->next->T_W_B, around->s);
}

Pose heldPoseAt(const Trajectory& path, TimeNs t) {
  const auto next = std::lower_bound(
      path.begin(), path.end(), t, [](const StampedPose& p, TimeNs stamp) { return p.t < stamp; });
  if (next == path.begin()) return path.front().T_W_B;
  if (next == path.end()) return path.back().T_W_B;
  const auto before = next - 1;
  return interpolate(before->T_W_B, next->T_W_B,
                     toSeconds(t - before->t) / toSeconds(next->t - before->t));
}

}  // namespace types
}  // namespace vir
