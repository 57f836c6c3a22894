#pragma once
/// The camera models behind makeCamera().
#include <array>
#include <functional>
#include <vector>

#include "vir/camera/camera_model.h"

namespace vir::camera {

/// The end of (0, x_max] up to which slope(x) is positive.
double positiveUpTo(const std::function<double(double)>& slope, double x_max);

/// Smallest x in (0, x_max] where the slope of the odd polynomial x (1 + c0 x^2 + c1 x^4 + ...)
/// vanishes; x_max if there is none. Beyond it the distortion folds back and has no inverse.
double turningPoint(const std::vector<double>& coefficients, double x_max);

/// Radial and tangential distortion of a plane, as of OpenCV: radtan, or rational with a radial
/// denominator.
class PlaneDistortion {
 public:
  /// k1 k2 p1 p2 k3.
  explicit PlaneDistortion(const std::array<double, 5>& radtan);
  /// k1 k2 p1 p2 k3 k4 k5 k6.
  explicit PlaneDistortion(const std::array<double, 8>& rational);
  /// Distorts the point `m`; `D` = d distorted / d m.
  Vec2 distort(const Vec2& m, Eigen::Matrix2d* D) const;
  /// The point whose image is `target`, found nearer than `tolerance` in the norm of
  /// `scale` times the error. False if there is none inside r_max.
  bool invert(const Vec2& target, const Vec2& scale, double tolerance, Vec2* m) const;
  /// Radius up to which there is an inverse.
  double rMax() const { return r_max_; }

 private:
  /// Factor of the point at squared radius `r2`, and twice its derivative with respect to that.
  double radial(double r2, double* slope) const;

  std::array<double, 8> k_;
  bool rational_;
  double r_max_ = 0.0;
};

/// Pinhole with a plane distortion (all coefficients zero for Distortion::none).
class PinholeCamera : public CameraModel {
 public:
  explicit PinholeCamera(const CameraCalibration& c);
  bool project(const Vec3& p_C, Vec2* px, Mat23* J) const override;
  bool unproject(const Vec2& px, Vec3* bearing_C) const override;

 private:
  PlaneDistortion plane_;
};

/// A sphere seen from xi behind its centre, and radtan on the plane it is projected to.
class OmniCamera : public CameraModel {
 public:
  explicit OmniCamera(const CameraCalibration& c);
  bool project(const Vec3& p_C, Vec2* px, Mat23* J) const override;
  bool unproject(const Vec2& px, Vec3* bearing_C) const override;

 private:
  double xi_;
  PlaneDistortion plane_;
};

/// Two spheres, xi apart, and a pinhole alpha/(1-alpha) behind the second.
class DoubleSphereCamera : public CameraModel {
 public:
  explicit DoubleSphereCamera(const CameraCalibration& c);
  bool project(const Vec3& p_C, Vec2* px, Mat23* J) const override;
  bool unproject(const Vec2& px, Vec3* bearing_C) const override;

 private:
  double xi_, alpha_;
  double min_z_;  ///< of a point at distance 1 that the model can project
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
