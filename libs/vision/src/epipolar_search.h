#pragma once
/// Internal: where another camera of known pose sees what one sees.
#include <memory>
#include <optional>

#include "image_pyramid.h"
#include "patch.h"
#include "vir/camera/camera_model.h"
#include "vir/geometry/pose.h"

namespace vir::vision {

/// A point as one camera sees it, its image, and the lens.
struct EpipolarView {
  const camera::CameraModel* camera = nullptr;
  const ImagePyramid* image = nullptr;
};

struct EpipolarOptions {
  double band_px = 2;  ///< to each side of the curve
  double most_inverse_m =
      0;  ///< inverse distance of the nearest that is looked for; 0: by baseline
  int patch_px = 15;
  int max_iterations = 8;
  double min_similarity = 0.88;
};

/// How far `b` (unit, in camera b) is beside the epipolar plane of `a` [px]. `T_b_a`: camera a in
/// camera b.
double besideCurvePx(const Pose& T_b_a, const Vec3& a, const Vec3& b, const Mat23& dpx_db);

/// In whole pixels: the samples of the curve of what `from` sees at `px`, at all distances from
/// the nearest to infinity, are compared at half the resolution with the neighbourhood of `px`, as
/// turned and scaled as the lenses have it; the one that is clearly the best is aligned at full
/// resolution. Searched back, it must lead to `px`. Nothing where none is.
std::optional<Vec2> matchAlongCurve(const EpipolarView& from, const Vec2& px,
                                    const EpipolarView& to, const Pose& T_to_from,
                                    const EpipolarOptions& options);

/// Inverse distance from camera a [1/m], by where both see it.
double inverseDistance(const Pose& T_b_a, const Vec3& a, const Vec3& b);

/// Share of the first camera's image that the second sees, of a scene some metres away.
double overlapOf(const camera::CameraModel& a, const camera::CameraModel& b, const Pose& T_b_a);

}  // namespace vir::vision
