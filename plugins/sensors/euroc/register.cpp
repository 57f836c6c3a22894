#include "euroc_dataset.h"
#include "vir/roles/sensor_registry.h"

namespace vir {

VIR_REGISTER_SENSOR(EurocDataset, "euroc",
                    "EuRoC (ASL) or TUM-VI folder: camera, IMU, ranges, ground truth");

VIR_REGISTER_SENSOR(
    CsvDataset, "csv",
    "Folder of tables (csv, txt) and images or a video: camera, IMU, ranges, ground truth");

}  // namespace vir
