#include <algorithm>
#include <cmath>

#include "window_state.h"

namespace vir::window {
namespace {

/// Known this well, a rolling shutter is told from a global one: those that roll take several
/// milliseconds [s].
constexpr double kKnownS = 0.001, kRollingS = 0.002;
/// What a global shutter is held to [s].
constexpr double kHeldS = 1e-5;

}  // namespace

void decideShutter(WindowState& w) {
  if (w.shutter_decided || !w.covariance.calibration) return;
  const double sigma = sigmaOf(w.covariance.calibration->diagonal().cwiseSqrt()).readout_s;
  if (sigma > kKnownS) return;
  w.shutter_decided = true;
  const double readout = w.camera_parameters[factors::kReadout];
  if (std::abs(readout) > std::max(kRollingS, 2 * sigma)) return;
  w.camera_parameters[factors::kReadout] = 0;
  w.calibration_sigma.readout_s = std::min(w.calibration_sigma.readout_s, kHeldS);
  for (std::size_t k = 0; k < w.prior_blocks.size(); ++k) {
    if (w.prior_blocks[k] != w.camera_parameters) continue;
    const factors::LinearPrior::Block& block = w.prior.blocks[k];
    const auto rows = w.prior.J.rows();
    w.prior.J.conservativeResizeLike(Eigen::MatrixXd::Zero(rows + 1, w.prior.J.cols()));
    w.prior.r0.conservativeResizeLike(Eigen::VectorXd::Zero(rows + 1));
    w.prior.J(rows, block.offset + factors::kReadout) = 1 / kHeldS;
    w.prior.r0[rows] = block.x0[factors::kReadout] / kHeldS;
  }
}

}  // namespace vir::window
