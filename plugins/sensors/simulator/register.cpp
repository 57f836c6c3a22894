#include "simulator_sensor.h"
#include "vir/roles/sensor_registry.h"

namespace vir {

VIR_REGISTER_SENSOR(SimulatorSensor, "simulator",
                    "made-up world: images or tracks, IMU, ranges, other robots, ground truth");

}  // namespace vir
