#pragma once
/// Differences of calibrations, and how sure one is, as vectors.
#include <array>
#include <cstddef>

#include "vir/types/calibration.h"

namespace vir {
inline namespace types {

/// A change of a calibration as a vector, in this order: position of the camera in the body [m],
/// its rotation on the right [rad], time offset [s], readout [s], both focal lengths together and
/// one against the other (relative), principal point [px], the two radial coefficients, gyro gain,
/// gyro axes [rad], accelerometer gain.
constexpr int kCalibrationSize = 23;
using CalibrationChange = Eigen::Matrix<double, kCalibrationSize, 1>;
using CalibrationCovariance = Eigen::Matrix<double, kCalibrationSize, kCalibrationSize>;

/// Where in `CameraCalibration::dist` the two coefficients are that move pixels along their
/// distance from the principal point most: k1 and k2, of a double sphere xi and alpha.
std::array<std::size_t, 2> radialCoefficients(Distortion distortion);
/// With these added to the two; a camera without distortion becomes one of `radtan`.
CameraCalibration withRadialChange(const CameraCalibration& camera, const Vec2& by);

/// What leads from `from` to `to`; focal lengths relative to `from`.
CalibrationChange changeBetween(const Calibration& from, const Calibration& to);
Calibration changed(const Calibration& from, const CalibrationChange& by);

/// The worst axis of each kind.
CalibrationSigma sigmaOf(const CalibrationChange& standard_deviations);
/// Variances on the diagonal.
CalibrationCovariance covarianceOf(const CalibrationSigma& sigma);

}  // namespace types
}  // namespace vir
