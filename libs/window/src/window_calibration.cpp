/// The calibration as the window takes it in, what is known of it at the beginning, and as
/// estimated.
#include <algorithm>

#include "vir/geometry/so3.h"
#include "window_state.h"

namespace vir::window {
namespace {

/// A camera with what was estimated of it.
CameraCalibration cameraWith(CameraCalibration camera, const factors::CameraVector& c) {
  camera.fx *= 1 + c[factors::kFocal] + c[factors::kAspect];
  camera.fy *= 1 + c[factors::kFocal] - c[factors::kAspect];
  camera.cx += c[factors::kCx];
  camera.cy += c[factors::kCy];
  const Vec2 radial = c.segment<2>(factors::kRadial1);
  return radial.isZero(0) ? camera : withRadialChange(camera, radial);
}

/// Appends one block whose local coordinates are known to `sigmas`.
void addPriorBlock(WindowState& w, double* data, int ambient, const std::vector<double>& sigmas) {
  const int rows = static_cast<int>(w.prior.J.rows()), cols = static_cast<int>(w.prior.J.cols());
  const int n = static_cast<int>(sigmas.size());
  w.prior.J.conservativeResizeLike(Eigen::MatrixXd::Zero(rows + n, cols + n));
  for (int i = 0; i < n; ++i) w.prior.J(rows + i, cols + i) = 1.0 / sigmas[i];
  w.prior.blocks.push_back({ambient, cols, std::vector<double>(data, data + ambient)});
  w.prior_blocks.push_back(data);
}

/// Cameras of a rig are calibrated together: what is known of another one is known against the
/// first. Call after the first one's blocks were added.
void addFurtherPrior(WindowState& w, FurtherCamera* added) {
  const CalibrationSigma& c = added->sigma;
  const int rows = static_cast<int>(w.prior.J.rows());
  const auto column_of = [&w](const double* data) {
    for (std::size_t k = 0; k < w.prior_blocks.size(); ++k) {
      if (w.prior_blocks[k] == data) return w.prior.blocks[k].offset;
    }
    return -1;
  };
  const int first = column_of(w.extrinsic), first_camera = column_of(w.camera_parameters);
  addPriorBlock(
      w, added->extrinsic, 7,
      {c.position_m, c.position_m, c.position_m, c.rotation_rad, c.rotation_rad, c.rotation_rad});
  addPriorBlock(w, added->parameters, factors::kCameraParameters,
                {c.time_offset_s, c.readout_s, c.focal, c.aspect, c.centre_px, c.centre_px,
                 c.distortion, c.distortion});
  const Pose T_B_C0 = w.T_B_C(), T_B_Ck = factors::poseFrom(added->extrinsic);
  const Mat3 R_Ck_C0 = T_B_Ck.R().transpose() * T_B_C0.R();
  const Vec3 arm_C0 = T_B_C0.inverse() * T_B_Ck.p;
  auto& J = w.prior.J;
  J.block<3, 3>(rows, first) = -Mat3::Identity() / c.position_m;
  J.block<3, 3>(rows, first + 3) = T_B_C0.R() * hat(arm_C0) / c.position_m;
  J.block<3, 3>(rows + 3, first + 3) = -R_Ck_C0 / c.rotation_rad;
  J(rows + 6, first_camera + factors::kTimeOffset) = -1 / c.time_offset_s;
}

}  // namespace

CalibrationSigma rigSigma(const WindowState& w, const FurtherCamera& camera, double misfit_px) {
  CalibrationSigma out = w.options.calibration;
  // What is given as a global shutter is taken for one [s].
  constexpr double kHeldS = 1e-5;
  if (camera.parameters[factors::kReadout] == 0) out.readout_s = kHeldS;
  if (misfit_px <= 0) return out;
  // Of a good calibration, whose matches lie this near to their curves [px]; whoever is off across
  // them is as likely off along them, where nothing shows it.
  constexpr double kGoodPx = 0.2;
  const double worse = std::max(1.0, misfit_px / kGoodPx);
  const auto atMost = [worse](double sigma, double* of) { *of = std::min(*of, worse * sigma); };
  // A rig that is turned by a milliradian or two is still one that was built to half a millimetre.
  constexpr double kBuiltPx = 1.5, kBuiltM = 0.0005;
  atMost(0.00025, &out.position_m);
  if (misfit_px < kBuiltPx) out.position_m = std::min(out.position_m, kBuiltM);
  atMost(0.0005, &out.rotation_rad);
  atMost(0.0005, &out.time_offset_s);
  atMost(0.002, &out.focal);
  atMost(0.0005, &out.aspect);
  atMost(1.0, &out.centre_px);
  return out;
}

void addCalibrationPrior(WindowState& w) {
  if (!w.options.calibrate) return;
  const CalibrationSigma& c = w.calibration_sigma;
  addPriorBlock(
      w, w.extrinsic, 7,
      {c.position_m, c.position_m, c.position_m, c.rotation_rad, c.rotation_rad, c.rotation_rad});
  // In the order of factors::CameraParameter.
  addPriorBlock(w, w.camera_parameters, factors::kCameraParameters,
                {c.time_offset_s, c.readout_s, c.focal, c.aspect, c.centre_px, c.centre_px,
                 c.distortion, c.distortion});
  std::vector<double> imu(imu::kImuIntrinsicsSize, c.gyro_gain);
  for (int i = 0; i < 3; ++i) {
    imu[static_cast<std::size_t>(imu::kGyroAxes + i)] = c.gyro_axes_rad;
    imu[static_cast<std::size_t>(imu::kAccGain + i)] = c.acc_gain;
  }
  addPriorBlock(w, w.imu_intrinsics, imu::kImuIntrinsicsSize, imu);
  for (FurtherCamera& further_camera : w.further) addFurtherPrior(w, &further_camera);
}

void takeCalibration(WindowState& w, const Calibration& calibration) {
  w.camera = calibration.camera;
  const bool looked_for = w.options.calibrate && w.options.lens != LensMode::given;
  w.radial_response =
      looked_for ? camera::RadialResponse(calibration.camera) : camera::RadialResponse();
  w.camera_parameters[factors::kTimeOffset] = calibration.time_offset_s;
  w.stamp_offset_s = calibration.time_offset_s;
  factors::poseTo(calibration.T_B_C, w.extrinsic);
  w.further.clear();
  for (const CameraMount& mount : calibration.further) {
    FurtherCamera c;
    c.given = mount.camera;
    if (looked_for) c.radial_response = camera::RadialResponse(mount.camera);
    c.offset_to_first_s = mount.time_offset_s - calibration.time_offset_s;
    factors::poseTo(mount.T_B_C, c.extrinsic);
    c.parameters[factors::kTimeOffset] = mount.time_offset_s;
    c.parameters[factors::kReadout] = mount.readout_s;
    c.sigma = rigSigma(w, c, 0);
    w.further.push_back(c);
  }
  for (int i = 0; i < 3; ++i) {
    w.imu_intrinsics[imu::kGyroGain + i] = calibration.gyro_gain[i];
    w.imu_intrinsics[imu::kGyroAxes + i] = calibration.gyro_axes_rad[i];
    w.imu_intrinsics[imu::kAccGain + i] = calibration.acc_gain[i];
  }
}

Calibration calibrationOf(const WindowState& w) {
  const factors::CameraVector c = w.cameraVector();
  Calibration out;
  out.T_B_C = w.T_B_C();
  out.time_offset_s = c[factors::kTimeOffset];
  out.readout_s = c[factors::kReadout];
  out.camera = cameraWith(w.camera, c);
  for (int k = 1; k < w.cameras(); ++k) {
    const factors::CameraVector v = w.cameraVector(k);
    out.further.push_back({cameraWith(w.beside(k).given, v), w.T_B_C(k), v[factors::kTimeOffset],
                           v[factors::kReadout]});
  }
  const imu::ImuIntrinsics k = w.imuIntrinsics();
  out.gyro_gain = k.segment<3>(imu::kGyroGain);
  out.gyro_axes_rad = k.segment<3>(imu::kGyroAxes);
  out.acc_gain = k.segment<3>(imu::kAccGain);
  return out;
}

}  // namespace vir::window
