#pragma once
/// The camera models behind makeCamera().
#include <vector>

#include "vir/camera/camera_model.h"

namespace vir::camera {

/// Smallest x in (0, x_max] where the slope of the odd polynomial x (1 + c0 x^2 + c1 x^4 + ...)
/// vanishes; x_max if there is none. Beyond it the distortion folds back and has no inverse.
double turningPoint(const std::vector<double>& coefficients, double x_max);

/// Pinhole with OpenCV's plumb-bob distortion (all coefficients zero for Distortion::none).
class PinholeCamera : public CameraModel {
 public:
  explicit PinholeCamera(const CameraCalibration& c);
  bool project(const Vec3& p_C, Vec2* px, Mat23* J) const override;
  bool unproject(const Vec2& px, Vec3* bearing_C) const override;

 private:
  /// Distorts the point `m` of the plane z = 1; `D` = d distorted / d m.
  Vec2 distort(const Vec2& m, Eigen::Matrix2d* D) const;
  bool invert(const Vec2& distorted, Vec2* m) const;
  double r_max_ = 0.0;  ///< radius in the plane z = 1 up to which the model holds
};

/// Kannala-Brandt. Holds beyond 90 deg from the axis, up to the turning point or 170 deg.
class EquidistantCamera : public CameraModel {
 public:
  explicit EquidistantCamera(const CameraCalibration& c);
  bool project(const Vec3& p_C, Vec2* px, Mat23* J) const override;
  bool unproject(const Vec2& px, Vec3* bearing_C) const override;

 private:
  /// Distance from the centre [in focal lengths] at angle `theta` [rad], and its slope.
  double radius(double theta, double* slope) const;
  double theta_max_ = 0.0;
};

}  // namespace vir::camera
