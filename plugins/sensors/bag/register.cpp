#include "bag_dataset.h"
#include "vir/roles/sensor_registry.h"

namespace vir {

VIR_REGISTER_SENSOR(Ros1Bag, "bag", "Bag of ROS 1: camera, IMU, ranges, poses");
VIR_REGISTER_SENSOR(Ros2Bag, "rosbag2",
                    "Bag of ROS 2 (folder, .db3) or MCAP: camera, IMU, ranges, poses");

}  // namespace vir
