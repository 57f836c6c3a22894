#pragma once
/// Internal: does the mirror image of an anchor at the plane of motion explain its ranges as well?
#include <vector>

#include "vir/window/long_window.h"

namespace vir::estimator {

struct MirrorComparison {
  bool valid = false;     ///< enough ranges for a plane of motion
  bool distinct = false;  ///< the two positions do not end up as one
  Vec3 here_p_W =
      Vec3::Zero();  ///< where the present position settles when the long window is solved
  Vec3 mirror_p_W = Vec3::Zero();
  double chi2 = 0;  ///< twice the loss there less twice the loss here: positive = here is better
};

/// The long window is solved for both, path and all: the path as it is has been bent to suit the
/// present position. `held` are the anchor's ranges with the antenna's position in W in `motion`;
/// `head_ranges` all ranges at the head; `mirror`: where to look for the other position, else the
/// image at the plane that fits the path best.
MirrorComparison compareMirror(const window::LongWindow& window, std::uint64_t key,
                               const std::vector<window::HeldRange>& held,
                               const std::vector<window::HeldRange>& head_ranges,
                               const Vec3* mirror);

}  // namespace vir::estimator
