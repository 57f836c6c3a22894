#pragma once
/// Which tracks agree with one rigid motion of the camera, given its rotation from the gyro.
#include <Eigen/StdVector>
#include <vector>

#include "vir/geometry/so3.h"

namespace vir::vision {

/// One track in two images.
struct BearingPair {
  Vec3 b0;   ///< unit bearing in the earlier camera frame
  Vec3 b1;   ///< unit bearing in the current camera frame
  Mat23 J1;  ///< projection Jacobian at b1 [px]
};

struct MotionVerdict {
  std::vector<unsigned char> inlier;
  Vec3 rotation_correction = Vec3::Zero();  ///< R_C0_C1 * Exp(correction) fits the tracks [rad]
  Vec3 direction = Vec3::Zero();  ///< unit position of C1 in C0; zero when there is no parallax
};

/// Fits the direction of translation (2 dof, two-point RANSAC with a fixed seed) to bearings whose
/// rotation is taken out, and refines it with a small common rotation (a gyro bias of 0.08 rad/s
/// is 2 px per image at 20 Hz): `rotation_sigma` [rad] says how wrong `R_C0_C1` may be. A track is
/// an outlier when it is farther than `threshold_px` from its epipolar line, or as far behind the
/// camera. Without parallax a track need only be within `threshold_px` of zero motion. Fewer than
/// three pairs are all accepted.
MotionVerdict filterByMotion(const std::vector<BearingPair>& pairs, const Mat3& R_C0_C1,
                             double rotation_sigma, double threshold_px);

}  // namespace vir::vision
