#include "vir/roles/estimator_registry.h"
#include "vir_estimator.h"

namespace vir {
VIR_REGISTER_ESTIMATOR(VirSettings, "vir", "camera, IMU and ranges in two sliding windows");
}  // namespace vir
