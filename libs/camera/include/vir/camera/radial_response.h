#pragma once
/// How pixels answer to the radial coefficients of a lens.
#include "vir/geometry/so3.h"
#include "vir/types/calibration.h"

namespace vir::camera {

/// A pixel at `off` from the principal point moves by `off` times at(off)[j] per unit of radial
/// coefficient j (types::radialCoefficients). A polynomial of the distance, fitted once to the
/// whole image, so that no model is asked for each sight.
class RadialResponse {
 public:
  /// Nothing answers.
  RadialResponse() = default;
  /// Of the camera as given. A camera without distortion answers as one of `radtan` with zeros.
  /// Throws std::invalid_argument where makeCamera does.
  explicit RadialResponse(const CameraCalibration& calibration);

  /// Relative change of the distance from the principal point per unit of either coefficient;
  /// `off` [px].
  Vec2 at(const Vec2& off) const;

 private:
  static constexpr int kTerms = 4;  // 1, rho^2, rho^4, rho^6
  using Terms = Eigen::Matrix<double, kTerms, 1>;
  Terms termsAt(const Vec2& off) const;

  double radius_px_ = 1;  // of the farthest corner
  Eigen::Matrix<double, kTerms, 2> weights_ = Eigen::Matrix<double, kTerms, 2>::Zero();
};

}  // namespace vir::camera
