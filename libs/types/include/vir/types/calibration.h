#pragma once
#include <array>
#include <vector>

#include "vir/geometry/pose.h"

namespace vir {
inline namespace types {

enum class Distortion { none, radtan, equidistant, rational, double_sphere, omni };

/// Intrinsics of a camera, and the model of its lens with the coefficients in `dist`:
/// - `radtan`: OpenCV's plumb-bob k1 k2 p1 p2 k3;
/// - `equidistant`: Kannala-Brandt k1 k2 k3 k4 (OpenCV's fisheye);
/// - `rational`: OpenCV's k1 k2 p1 p2 k3 k4 k5 k6, the last three in the denominator;
/// - `double_sphere`: xi alpha (Usenko, Demmel, Cremers 2018);
/// - `omni`: xi k1 k2 p1 p2, a sphere and radtan behind it (Mei, Rives 2007).
struct CameraCalibration {
  int width = 0;                          ///< [px]
  int height = 0;                         ///< [px]
  double fx = 0, fy = 0, cx = 0, cy = 0;  ///< [px]
  Distortion distortion = Distortion::none;
  std::array<double, 8> dist{};
};

/// A camera beside the first one of a rig, and how it and the IMU belong together.
struct CameraMount {
  CameraCalibration camera;
  Pose T_B_C;                ///< camera in the body (= IMU)
  double time_offset_s = 0;  ///< as of Calibration
  double readout_s = 0;      ///< as of Calibration
};

/// A camera, and how it and the IMU belong together.
struct Calibration {
  CameraCalibration camera;
  Pose T_B_C;                ///< camera in the body (= IMU)
  double time_offset_s = 0;  ///< stamp of an image + offset = its time on the IMU's clock
  /// Rolling shutter: time from the first row to the last, the middle one being seen at the image's
  /// time; 0 = all at once.
  double readout_s = 0;
  /// Of the IMU, beside its biases; rate = (I + diag(gyro_gain) + [gyro_axes]x) (reading - bias),
  /// acceleration = (I + diag(acc_gain)) (reading - bias).
  Vec3 gyro_gain = Vec3::Zero();          ///< relative, per axis
  Vec3 gyro_axes_rad = Vec3::Zero();      ///< turn of the gyro's axes against the accelerometer's
  Vec3 acc_gain = Vec3::Zero();           ///< relative, per axis
  std::vector<CameraMount> further = {};  ///< cameras beside the first: number 1, 2, ...
};

/// How far that may be off: standard deviations, of the worst axis where there are several.
struct CalibrationSigma {
  double position_m = 0.01;
  double rotation_rad = 0.02;
  double time_offset_s = 0.005;
  double readout_s = 0.02;
  double focal = 0.01;    ///< relative, of both focal lengths
  double aspect = 0.002;  ///< relative, of one against the other
  double centre_px = 4;
  double distortion = 0.01;  ///< of either radial coefficient (radialCoefficients)
  double gyro_gain = 0.005;  ///< relative, per axis
  double gyro_axes_rad = 0.005;
  double acc_gain = 0.005;  ///< relative, per axis
};

}  // namespace types
}  // namespace vir
