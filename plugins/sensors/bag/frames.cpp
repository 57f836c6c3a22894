#include "frames.h"

#include <cmath>
#include <vector>

namespace vir::bag {
namespace {

/// Frames of old had a slash before them.
std::string plain(std::string_view frame) {
  while (!frame.empty() && frame.front() == '/') frame.remove_prefix(1);
  return std::string(frame);
}

}  // namespace

std::optional<Pose> poseAt(const bags::MessageView& m, const std::string& point,
                           const std::string& quaternion) {
  const Vec3 p(m.number(point + ".x"), m.number(point + ".y"), m.number(point + ".z"));
  if (!p.allFinite()) return std::nullopt;
  if (quaternion.empty()) return Pose(Quat::Identity(), p);
  const Quat q(m.number(quaternion + ".w"), m.number(quaternion + ".x"),
               m.number(quaternion + ".y"), m.number(quaternion + ".z"));
  const double n = q.norm();
  if (!(std::abs(n - 1) < 0.1)) return std::nullopt;
  // What is of length 1 as well as numbers go stays as it is, digit by digit.
  return Pose(std::abs(n - 1) < 1e-12 ? q : q.normalized(), p);
}

std::optional<Pose> poseIn(const bags::MessageView& m, const std::string& type) {
  if (type == "geometry_msgs/PoseStamped") return poseAt(m, "pose.position", "pose.orientation");
  if (type == "geometry_msgs/TransformStamped") {
    return poseAt(m, "transform.translation", "transform.rotation");
  }
  if (type == "geometry_msgs/PointStamped") return poseAt(m, "point", "");
  return poseAt(m, "pose.pose.position", "pose.pose.orientation");
}

Mat3 positionCovarianceIn(const bags::MessageView& m) {
  Mat3 out = Mat3::Zero();
  const std::vector<double> all = m.numbers("pose.covariance", 36);
  for (int i = 0; i < 9 && all.size() == 36; ++i) {
    out(i / 3, i % 3) = all[static_cast<std::size_t>(6 * (i / 3) + i % 3)];
  }
  return out;
}

void FrameTree::add(const bags::MessageView& message) {
  constexpr std::size_t kMost = 10'000;
  message.each("transforms", [&](const bags::MessageView& t) {
    const std::string child = plain(t.text("child_frame_id"));
    const auto T = poseAt(t, "transform.translation", "transform.rotation");
    if (T && parents_.size() < kMost) parents_[child] = {plain(t.text("header.frame_id")), *T};
  });
}

std::pair<std::string, Pose> FrameTree::rootOf(std::string frame) const {
  Pose T;
  for (std::size_t steps = 0; steps <= parents_.size(); ++steps) {
    const auto link = parents_.find(frame);
    if (link == parents_.end()) break;
    T = steps == 0 ? link->second.T_P_C : link->second.T_P_C * T;
    frame = link->second.parent;
  }
  return {frame, T};
}

std::optional<Pose> FrameTree::between(const std::string& a, const std::string& b) const {
  const std::string from = plain(a), to = plain(b);
  if (from.empty() || to.empty()) return std::nullopt;
  const auto [root_a, T_R_A] = rootOf(from);
  const auto [root_b, T_R_B] = rootOf(to);
  if (root_a != root_b) return std::nullopt;
  if (root_a == from) return T_R_B;
  return T_R_A.inverse() * T_R_B;
}

}  // namespace vir::bag
