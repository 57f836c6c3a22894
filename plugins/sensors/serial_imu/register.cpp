#include "serial_imu.h"
#include "vir/roles/sensor_registry.h"

namespace vir {

VIR_REGISTER_SENSOR(SerialImu, "serial_imu",
                    "IMU live: text lines, binary frames, MAVLink from an autopilot");

}  // namespace vir
