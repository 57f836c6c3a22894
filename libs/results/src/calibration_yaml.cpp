#include "calibration_yaml.h"

#include "csv_text.h"

namespace vir::results {
namespace {

using csv::format;

std::string distortionOf(const CameraCalibration& c) {
  if (c.distortion == Distortion::equidistant) {
    return "  distortion_model: equidistant\n" +
           format("  distortion_coeffs: [%.9g, %.9g, %.9g, %.9g]\n", c.dist[0], c.dist[1],
                  c.dist[2], c.dist[3]);
  }
  if (c.distortion == Distortion::none)
    return "  distortion_model: none\n  distortion_coeffs: []\n";
  return "  distortion_model: radtan\n" +
         format("  distortion_coeffs: [%.9g, %.9g, %.9g, %.9g%s]\n", c.dist[0], c.dist[1],
                c.dist[2], c.dist[3], c.dist[4] != 0 ? format(", %.9g", c.dist[4]).c_str() : "");
}

}  // namespace

std::string calibrationYaml(const Calibration& calibration, const CalibrationSigma& sigma) {
  const CameraCalibration& c = calibration.camera;
  const Pose T_C_B = calibration.T_B_C.inverse();
  const Mat3 R = T_C_B.R();
  std::string out =
      "# Camera and IMU as estimated in this run, for --calibration of the next.\n"
      "# T_cam_imu takes points of the IMU to the camera; t_imu = t_cam + timeshift_cam_imu.\n"
      "cam0:\n  camera_model: pinhole\n";
  out += format("  intrinsics: [%.6f, %.6f, %.6f, %.6f]\n", c.fx, c.fy, c.cx, c.cy);
  out += format("  intrinsics_sigma: [%.6f, %.6f, %.6f, %.6f]\n", c.fx * sigma.focal,
                c.fy * sigma.focal, sigma.centre_px, sigma.centre_px);
  out += distortionOf(c) + format("  resolution: [%d, %d]\n", c.width, c.height) + "  T_cam_imu:\n";
  for (int r = 0; r < 3; ++r) {
    out += format("  - [%.12g, %.12g, %.12g, %.12g]\n", R(r, 0), R(r, 1), R(r, 2), T_C_B.p[r]);
  }
  out += "  - [0, 0, 0, 1]\n";
  out += format("  T_cam_imu_sigma: {position_m: %.6f, rotation_rad: %.6f}\n", sigma.position_m,
                sigma.rotation_rad);
  out += format("  timeshift_cam_imu: %.9f\n  timeshift_cam_imu_sigma: %.9f\n",
                calibration.time_offset_s, sigma.time_offset_s);
  out += format("  readout_s: %.9f\n", calibration.readout_s);
  return out;
}

}  // namespace vir::results
