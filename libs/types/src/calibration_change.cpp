#include "vir/types/calibration_change.h"

#include <algorithm>

namespace vir {
inline namespace types {
using Index = CalibrationIndex;

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
  d.segment<3>(Index::position) = to.T_B_C.p - from.T_B_C.p;
  d.segment<3>(Index::rotation) = logQuat(from.T_B_C.q.conjugate() * to.T_B_C.q);
  d[Index::time_offset] = to.time_offset_s - from.time_offset_s;
  d[Index::readout] = to.readout_s - from.readout_s;
  d[Index::focal] = (x + y) / 2;
  d[Index::aspect] = (x - y) / 2;
  d[Index::cx] = to.camera.cx - from.camera.cx;
  d[Index::cy] = to.camera.cy - from.camera.cy;
  const auto radial = radialCoefficients(to.camera.distortion);
  for (std::size_t j = 0; j < 2; ++j) {
    d[Index::radial + static_cast<int>(j)] =
        to.camera.dist[radial[j]] - from.camera.dist[radial[j]];
  }
  d.segment<3>(Index::gyro_gain) = to.gyro_gain - from.gyro_gain;
  d.segment<3>(Index::gyro_axes) = to.gyro_axes_rad - from.gyro_axes_rad;
  d.segment<3>(Index::acc_gain) = to.acc_gain - from.acc_gain;
  return d;
}

Calibration changed(const Calibration& from, const CalibrationChange& by) {
  Calibration to = from;
  to.T_B_C.p += by.segment<3>(Index::position);
  to.T_B_C.q = (from.T_B_C.q * expQuat(by.segment<3>(Index::rotation))).normalized();
  to.time_offset_s += by[Index::time_offset];
  to.readout_s += by[Index::readout];
  to.camera.fx *= 1 + by[Index::focal] + by[Index::aspect];
  to.camera.fy *= 1 + by[Index::focal] - by[Index::aspect];
  to.camera.cx += by[Index::cx];
  to.camera.cy += by[Index::cy];
  const Vec2 radial = by.segment<2>(Index::radial);
  if (!radial.isZero(0)) to.camera = withRadialChange(to.camera, radial);
  to.gyro_gain += by.segment<3>(Index::gyro_gain);
  to.gyro_axes_rad += by.segment<3>(Index::gyro_axes);
  to.acc_gain += by.segment<3>(Index::acc_gain);
  return to;
}

CalibrationSigma sigmaOf(const CalibrationChange& s) {
  CalibrationSigma out;
  out.position_m = s.segment<3>(Index::position).maxCoeff();
  out.rotation_rad = s.segment<3>(Index::rotation).maxCoeff();
  out.time_offset_s = s[Index::time_offset];
  out.readout_s = s[Index::readout];
  out.focal = s[Index::focal];
  out.aspect = s[Index::aspect];
  out.centre_px = std::max(s[Index::cx], s[Index::cy]);
  out.distortion = s.segment<2>(Index::radial).maxCoeff();
  out.gyro_gain = s.segment<3>(Index::gyro_gain).maxCoeff();
  out.gyro_axes_rad = s.segment<3>(Index::gyro_axes).maxCoeff();
  out.acc_gain = s.segment<3>(Index::acc_gain).maxCoeff();
  return out;
}

CalibrationCovariance covarianceOf(const CalibrationSigma& sigma) {
  CalibrationChange s;
  s.segment<3>(Index::position).setConstant(sigma.position_m);
  s.segment<3>(Index::rotation).setConstant(sigma.rotation_rad);
  s[Index::time_offset] = sigma.time_offset_s;
  s[Index::readout] = sigma.readout_s;
  s[Index::focal] = sigma.focal;
  s[Index::aspect] = sigma.aspect;
  s[Index::cx] = s[Index::cy] = sigma.centre_px;
  s.segment<2>(Index::radial).setConstant(sigma.distortion);
  s.segment<3>(Index::gyro_gain).setConstant(sigma.gyro_gain);
  s.segment<3>(Index::gyro_axes).setConstant(sigma.gyro_axes_rad);
  s.segment<3>(Index::acc_gain).setConstant(sigma.acc_gain);
  return s.cwiseAbs2().asDiagonal();
}

}  // namespace types
}  // namespace vir
