#include "odometry_estimator.h"
#include "vir/roles/estimator_registry.h"

namespace vir {
VIR_REGISTER_ESTIMATOR(OdometrySettings, "odometry",
                       "odometry poses and ranges in the long window (tracking camera, wheels)");
}  // namespace vir
