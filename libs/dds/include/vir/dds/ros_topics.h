#pragma once
/// Standard topics of ROS 2, for whoever listens on the domain.
#include <string>
#include <utility>
#include <vector>

#include "vir/core/log.h"
#include "vir/dds/link.h"
#include "vir/types/state.h"

namespace vir::dds {

/// Topics are made when they are first written to. Names as ROS 2 has them: `/robot1/odometry`. Any
/// thread; never waits.
class RosTopics {
 public:
  virtual ~RosTopics() = default;
  /// nav_msgs/Odometry: pose with covariance in `frame`, velocity [m/s] in `child`; no turning
  /// rate.
  virtual void odometry(const std::string& topic, const std::string& frame,
                        const std::string& child, const StateEstimate& estimate) = 0;
  /// geometry_msgs/PoseWithCovarianceStamped. `covariance`: of (position, rotation on the right)
  /// [m, rad].
  virtual void pose(const std::string& topic, const std::string& frame, const StampedPose& pose,
                    const Eigen::Matrix<double, 6, 6>& covariance) = 0;
  /// tf2_msgs/TFMessage with one transform, on `/tf`.
  virtual void transform(const std::string& frame, const std::string& child,
                         const StampedPose& pose) = 0;
  /// Messages written and not written, by name.
  virtual std::vector<std::pair<std::string, long>> counters() const = 0;
};

/// What the shared object has as `virOpenRosTopics`; throws as OpenLink.
using OpenRosTopics = RosTopics* (*)(const LinkOptions&, const LogSink&);

}  // namespace vir::dds
