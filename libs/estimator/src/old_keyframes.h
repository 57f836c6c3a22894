#pragma once
/// Keyframes that left the windows: all of them for those who take them as they come, and evenly
/// thinned out, so that the memory of a long run does not grow.
#include <utility>
#include <vector>

#include "vir/core/thinned_out.h"
#include "vir/types/followed_pose.h"
#include "vir/types/state.h"

namespace vir::estimator {

class OldKeyframes {
 public:
  void add(const FollowedPose& keyframe) {
    settled_.push_back(keyframe);
    kept_.add(keyframe);
  }
  std::vector<FollowedPose> takeSettled() { return std::exchange(settled_, {}); }
  const std::vector<StampedPose>& kept() const { return kept_.values(); }

 private:
  std::vector<FollowedPose> settled_;  // since they were last taken
  ThinnedOut<StampedPose> kept_{4096};
};

}  // namespace vir::estimator
