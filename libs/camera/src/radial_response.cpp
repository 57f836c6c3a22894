#include "vir/camera/radial_response.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "vir/camera/camera_model.h"
#include "vir/core/angles.h"
#include "vir/types/calibration_change.h"

namespace vir::camera {
namespace {

constexpr double kStep = 1e-4;
constexpr int kRadii = 12, kDirections = 8;

}  // namespace

RadialResponse::RadialResponse(const CameraCalibration& calibration) {
  const CameraCalibration c = withRadialChange(calibration, Vec2::Zero());
  const auto camera = makeCamera(c);
  const Vec2 centre(c.cx, c.cy);
  radius_px_ = std::hypot(std::max(c.cx, c.width - c.cx), std::max(c.cy, c.height - c.cy));
  for (int j = 0; j < 2; ++j) {
    const Vec2 step = kStep * Vec2::Unit(j);
    const auto more = makeCamera(withRadialChange(c, step));
    const auto less = makeCamera(withRadialChange(c, -step));
    Eigen::Matrix<double, kTerms, kTerms> H = Eigen::Matrix<double, kTerms, kTerms>::Zero();
    Terms g = Terms::Zero();
    for (int k = 0; k < kRadii * kDirections; ++k) {
      const double angle = 2 * kPi * (k % kDirections + 0.5) / kDirections;
      const Vec2 off = radius_px_ * (k / kDirections + 1) / kRadii *  // NOLINT: whole steps
                       Vec2(std::cos(angle), std::sin(angle));
      const Vec2 px = centre + off;
      if (px.x() < 0 || px.y() < 0 || px.x() > c.width || px.y() > c.height) continue;
      Vec3 bearing;
      Vec2 far, near;
      if (!camera->unproject(px, &bearing) || !more->project(bearing, &far) ||
          !less->project(bearing, &near)) {
        continue;
      }
      const double answer = (far - near).dot(off) / (2 * kStep * off.squaredNorm());
      const Terms terms = termsAt(off);
      H += terms * terms.transpose();
      g += terms * answer;
    }
    // A hair of damping: near a corner of the image the highest term has little to hold it.
    H.diagonal().array() += 1e-9;
    weights_.col(j) = H.ldlt().solve(g);
  }
}

RadialResponse::Terms RadialResponse::termsAt(const Vec2& off) const {
  const double rho2 = off.squaredNorm() / (radius_px_ * radius_px_);
  return Terms(1, rho2, rho2 * rho2, rho2 * rho2 * rho2);
}

Vec2 RadialResponse::at(const Vec2& off) const { return weights_.transpose() * termsAt(off); }

}  // namespace vir::camera
