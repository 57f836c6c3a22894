#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "window_state.h"

namespace vir::window {
namespace {

constexpr int kRadial = CalibrationIndex::radial;

/// Further off than this many standard deviations, in as many keyframes in a row: another lens.
constexpr double kContradiction = 6.5;
constexpr int kContradictions = 3;
/// No lens is quite what its model says, and errors of tracks are alike in neighbouring images:
/// what moves the corner of the image by less is no reason [px].
constexpr double kMattersPx = 2;

/// Of the corner of the image.
double shiftPx(const WindowState& w, const Vec2& change) {
  const CameraCalibration& c = w.camera;
  const Vec2 corner(std::max(c.cx, c.width - c.cx), std::max(c.cy, c.height - c.cy));
  return corner.norm() * std::abs(w.radial_response.at(corner).dot(change));
}

}  // namespace

void watchLens(WindowState& w) {
  if (!w.calibrating() || !w.lens_held || w.options.lens == LensMode::given) return;
  if (!w.covariance.calibration) return;
  CalibrationCovariance& known = *w.covariance.calibration;
  const Eigen::Matrix2d covariance = known.block<2, 2>(kRadial, kRadial);
  const Vec2 off = w.covariance.calibration_step.segment<2>(kRadial);
  const double squares = off.dot(covariance.inverse() * off);
  const bool contradicted =
      squares > kContradiction * kContradiction && shiftPx(w, off) > kMattersPx;
  w.lens_doubts = contradicted ? w.lens_doubts + 1 : 0;
  w.lens_held = w.lens_doubts < kContradictions;
  // What is held is as far off as the sights say, give and take what they do not know.
  if (w.lens_held) known.block<2, 2>(kRadial, kRadial) += off * off.transpose();
}

void holdLens(const WindowState& w, NormalEquations* information) {
  constexpr double kHeld = 1e-7;
  if (!w.lens_held) return;
  for (int k = 0; k < w.cameras(); ++k) {
    const int camera = information->offsetOf(k == 0 ? w.camera_parameters : w.beside(k).parameters);
    if (camera < 0) continue;
    for (const int i : {factors::kRadial1, factors::kRadial2}) {
      information->H(camera + i, camera + i) += 1 / (kHeld * kHeld);
    }
  }
}

}  // namespace vir::window
