#pragma once

namespace vir::estimator {

/// Position [m] and yaw [rad] of the first frame are the world's by definition.
constexpr double kStartSigma = 1e-3;

}  // namespace vir::estimator
