/// What the window takes for the calibration, and how sure it is of that.
#include <algorithm>

#include "vir/window/short_window.h"
#include "window_state.h"

namespace vir::window {

Pose ShortWindow::extrinsics() const { return impl_->T_B_C(); }
imu::ImuIntrinsics ShortWindow::imuIntrinsics() const { return impl_->imuIntrinsics(); }
double ShortWindow::timeOffset() const { return impl_->camera_parameters[factors::kTimeOffset]; }

void ShortWindow::setTimeOffset(double time_offset_s, double sigma_s) {
  impl_->calibration_sigma.time_offset_s = sigma_s;
  impl_->camera_parameters[factors::kTimeOffset] = time_offset_s;
  impl_->stamp_offset_s = time_offset_s;
}

void ShortWindow::setCalibration(const Calibration& calibration) {
  impl_->camera = calibration.camera;
  const bool looked_for = impl_->options.calibrate && impl_->options.lens != LensMode::given;
  impl_->radial_response =
      looked_for ? camera::RadialResponse(calibration.camera) : camera::RadialResponse();
  impl_->camera_parameters[factors::kTimeOffset] = calibration.time_offset_s;
  impl_->stamp_offset_s = calibration.time_offset_s;
  factors::poseTo(calibration.T_B_C, impl_->extrinsic);
  for (int i = 0; i < 3; ++i) {
    impl_->imu_intrinsics[imu::kGyroGain + i] = calibration.gyro_gain[i];
    impl_->imu_intrinsics[imu::kGyroAxes + i] = calibration.gyro_axes_rad[i];
    impl_->imu_intrinsics[imu::kAccGain + i] = calibration.acc_gain[i];
  }
}

void ShortWindow::setExtrinsicsSigma(double position_m, double rotation_rad) {
  CalibrationSigma& s = impl_->calibration_sigma;
  s.position_m = std::max(impl_->options.calibration.position_m, position_m);
  s.rotation_rad = std::max(impl_->options.calibration.rotation_rad, rotation_rad);
}

CalibrationSigma ShortWindow::calibrationSigma() const {
  if (!impl_->covariance.calibration) return impl_->calibration_sigma;
  return sigmaOf(impl_->covariance.calibration->diagonal().cwiseMax(0).cwiseSqrt());
}

std::optional<CalibrationCovariance> ShortWindow::calibrationCovariance() const {
  return impl_->covariance.calibration;
}

bool ShortWindow::lensContradicted() const {
  return impl_->options.lens == LensMode::watched && !impl_->lens_held;
}

void ShortWindow::stampWith(double time_offset_s) { impl_->stamp_offset_s = time_offset_s; }
void ShortWindow::setStampSigma(double sigma_s) { impl_->stamp_sigma_s = sigma_s; }

Calibration ShortWindow::calibration() const {
  const factors::CameraVector c = impl_->cameraVector();
  Calibration out = {impl_->camera, impl_->T_B_C(), c[factors::kTimeOffset], c[factors::kReadout]};
  out.camera.fx *= 1 + c[factors::kFocal] + c[factors::kAspect];
  out.camera.fy *= 1 + c[factors::kFocal] - c[factors::kAspect];
  out.camera.cx += c[factors::kCx];
  out.camera.cy += c[factors::kCy];
  const Vec2 radial = c.segment<2>(factors::kRadial1);
  if (!radial.isZero(0)) out.camera = withRadialChange(out.camera, radial);
  const imu::ImuIntrinsics k = impl_->imuIntrinsics();
  out.gyro_gain = k.segment<3>(imu::kGyroGain);
  out.gyro_axes_rad = k.segment<3>(imu::kGyroAxes);
  out.acc_gain = k.segment<3>(imu::kAccGain);
  return out;
}

}  // namespace vir::window
