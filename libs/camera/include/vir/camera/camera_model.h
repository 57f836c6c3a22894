#pragma once
/// Projection of points in the camera frame (x right, y down, z forward) to pixels and back.
#include <memory>
#include <string>

#include "vir/geometry/so3.h"
#include "vir/types/calibration.h"

namespace vir::camera {

class CameraModel {
 public:
  virtual ~CameraModel() = default;
  /// Pixel of a point `p_C` (any length). False where the model does not hold (behind the image
  /// plane, beyond the distortion's turning point): outputs are then unspecified but finite.
  /// `J` [px per unit of p_C] = d px / d p_C, optional.
  virtual bool project(const Vec3& p_C, Vec2* px, Mat23* J = nullptr) const = 0;
  /// Unit bearing of a pixel. False when the inversion does not converge to the pixel within
  /// 0.01 px (never NaN).
  virtual bool unproject(const Vec2& px, Vec3* bearing_C) const = 0;
  const CameraCalibration& calibration() const { return calibration_; }

 protected:
  explicit CameraModel(const CameraCalibration& c) : calibration_(c) {}
  CameraCalibration calibration_;
};

/// Throws std::invalid_argument naming the value for a calibration that cannot be one (size or
/// focal length not positive, not finite).
std::shared_ptr<const CameraModel> makeCamera(const CameraCalibration& calibration);

}  // namespace vir::camera
