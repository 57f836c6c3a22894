#include "pyfg_dataset.h"
#include "vir/roles/sensor_registry.h"

namespace vir {

VIR_REGISTER_SENSOR(PyfgDataset, "pyfg",
                    "PyFG factor graph: one robot's odometry, ranges, ground truth");

}  // namespace vir
