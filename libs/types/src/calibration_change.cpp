#include "vir/types/calibration_change.h"

#include <algorithm>

namespace vir {
inline namespace types {
namespace {

enum Index {
  kPosition = 0,
  kRotation = 3,
  kTimeOffset = 6,
  kReadout,
  kFocal,
  kAspect,
  kCx,
  kCy,
  kRadial,
  kGyroGain = 14,
  kGyroAxes = 17,
  kAccGain = 20
};

}  // namespace

std::array<std::size_t, 2> radialCoefficients(Distortion distortion) {
  if (distortion == Distortion::omni) return {1, 2};
  return {0, 1};
}

CameraCalibration withRadialChange(const CameraCalibration& camera, const Vec2& by) {
  CameraCalibration out = camera;
  if (camera.distortion == Distortion::none) out.distortion = Distortion::radtan;
  const auto [first, second] = radialCoefficients(out.distortion);
  out.dist[first] += by.x();
  out.dist[second] += by.y();
  return out;
}

CalibrationChange changeBetween(const Calibration& from, const Calibration& to) {
  CalibrationChange d;
  const double x = to.camera.fx / from.camera.fx - 1, y = to.camera.fy / from.camera.fy - 1;
  d.segment<3>(kPosition) = to.T_B_C.p - from.T_B_C.p;
  d.segment<3>(kRotation) = logQuat(from.T_B_C.q.conjugate() * to.T_B_C.q);
  d[kTimeOffset] = to.time_offset_s - from.time_offset_s;
  d[kReadout] = to.readout_s - from.readout_s;
  d[kFocal] = (x + y) / 2;
  d[kAspect] = (x - y) / 2;
  d[kCx] = to.camera.cx - from.camera.cx;
  d[kCy] = to.camera.cy - from.camera.cy;
  const auto radial = radialCoefficients(to.camera.distortion);
  for (std::size_t j = 0; j < 2; ++j) {
    d[kRadial + static_cast<int>(j)] = to.camera.dist[radial[j]] - from.camera.dist[radial[j]];
  }
  d.segment<3>(kGyroGain) = to.gyro_gain - from.gyro_gain;
  d.segment<3>(kGyroAxes) = to.gyro_axes_rad - from.gyro_axes_rad;
  d.segment<3>(kAccGain) = to.acc_gain - from.acc_gain;
  return d;
}

Calibration changed(const Calibration& from, const CalibrationChange& by) {
  Calibration to = from;
  to.T_B_C.p += by.segment<3>(kPosition);
  to.T_B_C.q = (from.T_B_C.q * expQuat(by.segment<3>(kRotation))).normalized();
  to.time_offset_s += by[kTimeOffset];
  to.readout_s += by[kReadout];
  to.camera.fx *= 1 + by[kFocal] + by[kAspect];
  to.camera.fy *= 1 + by[kFocal] - by[kAspect];
  to.camera.cx += by[kCx];
  to.camera.cy += by[kCy];
  const Vec2 radial = by.segment<2>(kRadial);
  if (!radial.isZero(0)) to.camera = withRadialChange(to.camera, radial);
  to.gyro_gain += by.segment<3>(kGyroGain);
  to.gyro_axes_rad += by.segment<3>(kGyroAxes);
  to.acc_gain += by.segment<3>(kAccGain);
  return to;
}

CalibrationSigma sigmaOf(const CalibrationChange& s) {
  CalibrationSigma out;
  out.position_m = s.segment<3>(kPosition).maxCoeff();
  out.rotation_rad = s.segment<3>(kRotation).maxCoeff();
  out.time_offset_s = s[kTimeOffset];
  out.readout_s = s[kReadout];
  out.focal = s[kFocal];
  out.aspect = s[kAspect];
  out.centre_px = std::max(s[kCx], s[kCy]);
  out.distortion = s.segment<2>(kRadial).maxCoeff();
  out.gyro_gain = s.segment<3>(kGyroGain).maxCoeff();
  out.gyro_axes_rad = s.segment<3>(kGyroAxes).maxCoeff();
  out.acc_gain = s.segment<3>(kAccGain).maxCoeff();
  return out;
}

CalibrationCovariance covarianceOf(const CalibrationSigma& sigma) {
  CalibrationChange s;
  s.segment<3>(kPosition).setConstant(sigma.position_m);
  s.segment<3>(kRotation).setConstant(sigma.rotation_rad);
  s[kTimeOffset] = sigma.time_offset_s;
  s[kReadout] = sigma.readout_s;
  s[kFocal] = sigma.focal;
  s[kAspect] = sigma.aspect;
  s[kCx] = s[kCy] = sigma.centre_px;
  s.segment<2>(kRadial).setConstant(sigma.distortion);
  s.segment<3>(kGyroGain).setConstant(sigma.gyro_gain);
  s.segment<3>(kGyroAxes).setConstant(sigma.gyro_axes_rad);
  s.segment<3>(kAccGain).setConstant(sigma.acc_gain);
  return s.cwiseAbs2().asDiagonal();
}

}  // namespace types
}  // namespace vir
