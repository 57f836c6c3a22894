#pragma once
/// Where sensors sit on the robot, as /tf_static tells it.
#include <map>
#include <optional>
#include <string>

#include "vir/bags/message_view.h"
#include "vir/geometry/pose.h"

namespace vir::bag {

class FrameTree {
 public:
  /// Takes a TFMessage.
  void add(const bags::MessageView& message);
  /// T_A_B between two frames that hang together; empty if they do not.
  std::optional<Pose> between(const std::string& a, const std::string& b) const;
  bool empty() const { return parents_.empty(); }

 private:
  struct Link {
    std::string parent;
    Pose T_P_C;  ///< child in parent
  };
  /// Up to the root: the root's name, and the frame in it.
  std::pair<std::string, Pose> rootOf(std::string frame) const;

  std::map<std::string, Link> parents_;
};

/// A pose from its seven numbers; empty if they are none. `quaternion` and `point`: paths.
std::optional<Pose> poseAt(const bags::MessageView& m, const std::string& point,
                           const std::string& quaternion);
/// That of a message of one of the standard types with a pose; empty if its numbers are none.
std::optional<Pose> poseIn(const bags::MessageView& m, const std::string& type);
/// Of the position in a PoseWithCovarianceStamped or Odometry [m^2]; 0 where there is none.
Mat3 positionCovarianceIn(const bags::MessageView& m);

}  // namespace vir::bag
