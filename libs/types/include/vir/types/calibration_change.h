#pragma once
/// Differences of calibrations, and how sure one is, as vectors.
#include <array>
#include <cstddef>

#include "vir/types/calibration.h"

namespace vir {
inline namespace types {

/// Where what stands in a CalibrationChange; vectors begin there.
struct CalibrationIndex {
  enum : int {
    position = 0,     ///< of the camera in the body [m], 3
    rotation = 3,     ///< of the camera, on the right [rad], 3
    time_offset = 6,  ///< [s]
    readout,          ///< [s]
    focal,            ///< both focal lengths together, relative
    aspect,           ///< one against the other, relative
    cx,               ///< principal point [px]
    cy,
    radial,          ///< radialCoefficients(), 2
    gyro_gain = 14,  ///< 3
    gyro_axes = 17,  ///< [rad], 3
    acc_gain = 20,   ///< 3
    size = 23
  };
};

/// A change of a calibration as a vector, by CalibrationIndex.
constexpr int kCalibrationSize = CalibrationIndex::size;
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
