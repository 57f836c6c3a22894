#pragma once
#include <memory>
#include <string>
#include <vector>

#include "vir/dds/ros_topics.h"
#include "vir/results/run_observer.h"
#include "vir/team/peer_result.h"

namespace vir::app {

/// The run as standard topics of ROS 2 while it goes on: `odometry`, `pose`, `/tf`, and for every
/// robot that is placed `robot_<id>/pose` and its transform.
class RosStream final : public results::RunObserver {
 public:
  /// Throws std::runtime_error: built without DDS, a namespace that ROS would not take, or what the
  /// link throws.
  RosStream(const dds::LinkOptions& options, const LogSink& log);

  /// In the thread of the estimation, as onOutput().
  void onPeers(const std::vector<team::PeerResult>& peers);
  void onOutput(const roles::EstimatorOutput& output, const roles::Estimator& estimator) override;
  /// What was written, a line.
  std::string report() const;

 private:
  std::string name_;   ///< before topics: empty, or begins with a slash
  std::string frame_;  ///< before frames: empty, or ends with a slash
  int domain_;
  std::unique_ptr<dds::RosTopics> topics_;
};

}  // namespace vir::app
