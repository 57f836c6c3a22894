#pragma once
/// A place that was seen before, and what is remembered of one.
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "vir/core/time.h"
#include "vir/geometry/pose.h"

namespace vir {
inline namespace types {

/// A corner of a keyframe's image as it is remembered.
struct PlacePoint {
  Eigen::Vector2f px = Eigen::Vector2f::Zero();     ///< [px] of the image as recorded
  Eigen::Vector3f ray_C = Eigen::Vector3f::Zero();  ///< of unit length, in the camera
  float inverse_distance = 0;                       ///< along ray_C [1/m]; 0: not known
  float inverse_distance_sigma = 0;                 ///< [1/m]
  std::array<std::uint8_t, 32> descriptor{};        ///< binary, compared by Hamming distance
};

/// What is remembered of a keyframe. The path is in W as the estimator gave it: smooth but for
/// what ranges moved.
struct PlaceKeyframe {
  std::uint64_t id = 0;  ///< rises with time within a map
  TimeNs t = 0;
  int segment = 0;  ///< as of `StateEstimate`: poses of two segments are tied loosely
  Pose T_W_B;
  Pose T_B_C;
  std::vector<PlacePoint> points;
};

/// A verified second visit: where the body of the newer keyframe is, as seen from the older one's.
struct Loop {
  std::uint64_t older = 0, newer = 0;  ///< ids of keyframes
  Pose T_older_newer;                  ///< body to body
  /// Of (position in the older body [m], rotation on the right [rad]).
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  int matches = 0, inliers = 0;
};

}  // namespace types
}  // namespace vir
