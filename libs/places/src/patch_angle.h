#pragma once
/// How a patch is turned before it is described.
#include <opencv2/core/mat.hpp>

#include "vir/camera/camera_model.h"
#include "vir/types/loop.h"

namespace vir::places {

/// Direction of "down" in the image at a point [deg, 0 to 360, from x towards y]; where the ray
/// itself points nearly up or down, that of the brighter side of the patch of radius `reach_px`.
double patchAngle(const cv::Mat& gray, const camera::CameraModel& camera, const PlacePoint& point,
                  const Vec3& down_C, int reach_px);

}  // namespace vir::places
