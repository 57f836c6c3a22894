#include "live/ros_stream.h"

#include <algorithm>
#include <cctype>
#include <stdexcept>

#include "live/program_module.h"

namespace vir::app {
namespace {

/// Without slashes before and behind it. Throws for what ROS would not take.
std::string checkedNamespace(const std::string& text) {
  const std::size_t from = text.find_first_not_of('/');
  if (from == std::string::npos) return "";
  const std::string name = text.substr(from, text.find_last_not_of('/') + 1 - from);
  char before = '/';
  for (const char c : name) {
    const bool letter = std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '_';
    const bool inside = std::isdigit(static_cast<unsigned char>(c)) != 0 || c == '/';
    if (!letter && (!inside || before == '/')) {
      throw std::runtime_error("Dds.ros2_namespace = " + text +
                               ": ROS takes words of letters, digits and _ that begin with no "
                               "digit, with / between them");
    }
    before = c;
  }
  return name;
}

}  // namespace

RosStream::RosStream(const dds::LinkOptions& options, const LogSink& log)
    : domain_(options.domain) {
  const std::string name = checkedNamespace(options.ros2_namespace);
  if (!name.empty()) {
    name_ = "/" + name;
    frame_ = name + "/";
  }
  const auto open = reinterpret_cast<dds::OpenRosTopics>(functionOfDds("virOpenRosTopics"));
  topics_.reset(open(options, log));
}

void RosStream::onOutput(const roles::EstimatorOutput& output,
                         const roles::Estimator& /*estimator*/) {
  const std::string world = frame_ + "world", body = frame_ + "imu";
  for (const StateEstimate& e : output.states) {
    if (!e.valid) continue;
    const StampedPose pose{e.state.t, e.state.T_W_B};
    topics_->odometry(name_ + "/odometry", world, body, e);
    topics_->pose(name_ + "/pose", world, pose, e.covariance);
    topics_->transform(world, body, pose);
  }
}

void RosStream::onPeers(const std::vector<team::PeerResult>& peers) {
  for (const team::PeerResult& peer : peers) {
    const auto there = team::poseInOwnWorld(peer);
    if (!there) continue;
    // A sign is no part of a name.
    const std::string robot = "robot_" + std::to_string(static_cast<std::uint32_t>(peer.id));
    topics_->pose(name_ + "/" + robot + "/pose", frame_ + "world", {there->t, there->T_W_B},
                  there->covariance);
    topics_->transform(frame_ + "world", frame_ + robot, {there->t, there->T_W_B});
  }
}

std::string RosStream::report() const {
  std::string line = "topics of ROS 2 on domain " + std::to_string(domain_);
  for (const auto& [name, count] : topics_->counters()) {
    line += ", " + name + " " + std::to_string(count);
  }
  return line;
}

}  // namespace vir::app
