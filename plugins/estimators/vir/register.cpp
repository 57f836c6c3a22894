#include "vir/pipeline/estimator_registry.h"
#include "vir_estimator.h"

namespace vir {
VIR_REGISTER_ESTIMATOR(VirEstimator, "vir",
                       "visual-inertial odometry in a sliding window (camera, IMU)");
}  // namespace vir
