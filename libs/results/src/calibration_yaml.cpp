#include "vir/results/calibration_yaml.h"

#include <algorithm>

#include "csv_text.h"
#include "vir/core/text.h"
#include "vir/formats/lens_names.h"

namespace vir::results {
namespace {

using csv::format;

std::string list(const double* values, std::size_t count) {
  std::string out = "[";
  for (std::size_t i = 0; i < count; ++i) out += (i > 0 ? ", " : "") + format("%.9g", values[i]);
  return out + "]";
}

/// A block of the chain; standard deviations where there are any.
std::string cameraBlock(const std::string& name, const CameraMount& mount,
                        const CalibrationSigma* sigma) {
  const CameraCalibration& c = mount.camera;
  const Pose T_C_B = mount.T_B_C.inverse();
  const Mat3 R = T_C_B.R();
  std::string out = name + ":\n";
  const formats::ListedLens lens = formats::listedLens(c);
  out += "  camera_model: " + lens.camera_model + "\n  intrinsics: [";
  for (const double v : lens.before_focal) out += format("%.9g, ", v);
  out += format("%.6f, %.6f, %.6f, %.6f]\n", c.fx, c.fy, c.cx, c.cy);
  if (sigma) {
    out += format("  focal_and_centre_sigma: [%.6g, %.6g, %.6g, %.6g]\n", c.fx * sigma->focal,
                  c.fy * sigma->focal, sigma->centre_px, sigma->centre_px);
    out += format("  aspect_sigma: %.6g\n", sigma->aspect);
  }
  out += "  distortion_model: " + lens.distortion_model + "\n";
  out += "  distortion_coeffs: " + list(lens.coefficients.data(), lens.coefficients.size()) + "\n";
  if (sigma) out += format("  distortion_sigma: %.6g\n", sigma->distortion);
  out += format("  resolution: [%d, %d]\n", c.width, c.height) + "  T_cam_imu:\n";
  for (int r = 0; r < 3; ++r) {
    out += format("  - [%.12g, %.12g, %.12g, %.12g]\n", R(r, 0), R(r, 1), R(r, 2), T_C_B.p[r]);
  }
  out += "  - [0, 0, 0, 1]\n";
  if (sigma) {
    out += format("  T_cam_imu_sigma: {position_m: %.6g, rotation_rad: %.6g}\n", sigma->position_m,
                  sigma->rotation_rad);
  }
  out += format("  timeshift_cam_imu: %.9f\n", mount.time_offset_s);
  if (sigma) out += format("  timeshift_cam_imu_sigma: %.6g\n", sigma->time_offset_s);
  out += format("  readout_s: %.9f\n", mount.readout_s);
  if (sigma) out += format("  readout_sigma_s: %.6g\n", sigma->readout_s);
  return out;
}

/// CAM1, CAM2, ...: what a chain and the readers of one know.
bool isOfChain(const std::string& name) {
  return name.size() > 3 && name.compare(0, 3, "cam") == 0 && name[3] != '0' &&
         std::all_of(name.begin() + 3, name.end(), [](char x) { return x >= '0' && x <= '9'; });
}

}  // namespace

std::string calibrationYaml(const Calibration& calibration, const CalibrationSigma& sigma,
                            const std::vector<std::string>& further_labels,
                            const std::vector<CalibrationSigma>& further_sigma) {
  std::string out =
      "# Camera and IMU as estimated in this run, for --calibration of the next.\n"
      "# T_cam_imu takes points of the IMU to the camera; t_imu = t_cam + timeshift_cam_imu.\n";
  out += cameraBlock(
      "cam0",
      {calibration.camera, calibration.T_B_C, calibration.time_offset_s, calibration.readout_s},
      &sigma);
  for (std::size_t k = 0; k < std::min(calibration.further.size(), further_labels.size()); ++k) {
    const std::string name = lowerCase(further_labels[k]);
    if (isOfChain(name)) {
      out += cameraBlock(name, calibration.further[k],
                         k < further_sigma.size() ? &further_sigma[k] : nullptr);
    } else {
      out += "# " + further_labels[k] + " is left out: only CAM1, CAM2, ... can stand here.\n";
    }
  }
  // A camchain holds cameras only; these stand beside them.
  out += "inertial:\n  gyro_gain: " + list(calibration.gyro_gain.data(), 3);
  out += format("\n  gyro_gain_sigma: %.6g\n  gyro_axes_rad: ", sigma.gyro_gain);
  out += list(calibration.gyro_axes_rad.data(), 3);
  out += format("\n  gyro_axes_sigma_rad: %.6g\n  acc_gain: ", sigma.gyro_axes_rad);
  out += list(calibration.acc_gain.data(), 3);
  out += format("\n  acc_gain_sigma: %.6g\n", sigma.acc_gain);
  return out;
}

}  // namespace vir::results
