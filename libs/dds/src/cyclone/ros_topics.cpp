#include "cyclone/ros_topics.h"

#include <algorithm>
#include <map>
#include <mutex>

#include "cyclone/domain.h"
#include "ros2.h"
#include "vir/types/fixed_axes.h"

namespace vir::dds {
namespace {

constexpr std::int32_t kDepth = 10;  // that of ROS 2 by itself
constexpr double kNotTold = 1e6;     // variance, as users of ROS read it
constexpr TimeNs kSecond = 1'000'000'000;

/// A type and its hash (REP 2016): ROS 2 from Iron on looks for it, and for nothing else, in the
/// user data of whoever writes.
struct RosType {
  const dds_topic_descriptor_t* type;
  const char* hash;
};
const RosType kOdometry{&nav_msgs_msg_dds__Odometry__desc,
                        "3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0"};
const RosType kPose{&geometry_msgs_msg_dds__PoseWithCovarianceStamped__desc,
                    "26432f9803e43727d3c8f668d1fdb3c630f548af631e2f4e31382371bfea3b6e"};
const RosType kTransforms{&tf2_msgs_msg_dds__TFMessage__desc,
                          "e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087"};

/// DDS writes a sample's text and never changes it.
char* text(const std::string& s) { return const_cast<char*>(s.c_str()); }

std_msgs_msg_dds__Header_ header(TimeNs t, const std::string& frame) {
  // Seconds are the floor, also before 1970.
  const TimeNs s = t / kSecond - (t % kSecond < 0 ? 1 : 0);
  return {{static_cast<std::int32_t>(s), static_cast<std::uint32_t>(t - s * kSecond)}, text(frame)};
}

geometry_msgs_msg_dds__Quaternion_ quaternion(const Quat& q) {
  return {q.x(), q.y(), q.z(), q.w()};
}

geometry_msgs_msg_dds__PoseWithCovariance_ poseOf(const Pose& T,
                                                  const Eigen::Matrix<double, 6, 6>& covariance) {
  geometry_msgs_msg_dds__PoseWithCovariance_ out{};
  out.pose = {{T.p.x(), T.p.y(), T.p.z()}, quaternion(T.q)};
  const Eigen::Matrix<double, 6, 6> C = fixedAxesCovariance(T, covariance);
  for (int i = 0; i < 36; ++i) out.covariance[i] = C(i / 6, i % 6);
  return out;
}

class CycloneRosTopics final : public RosTopics {
 public:
  CycloneRosTopics(const LinkOptions& o, const LogSink& log) : domain_(Domain::of(o, log)) {}

  void odometry(const std::string& topic, const std::string& frame, const std::string& child,
                const StateEstimate& e) override {
    const State& s = e.state;
    nav_msgs_msg_dds__Odometry_ m{};
    m.header = header(s.t, frame);
    m.child_frame_id = text(child);
    m.pose = poseOf(s.T_W_B, e.covariance);
    const Vec3 v = s.T_W_B.q.conjugate() * s.v;
    m.twist.twist.linear = {v.x(), v.y(), v.z()};
    // How sure the velocity is nobody has estimated (0); the turning rate is not told.
    for (int i = 3; i < 6; ++i) m.twist.covariance[7 * i] = kNotTold;
    write(topic, kOdometry, &m);
  }

  void pose(const std::string& topic, const std::string& frame, const StampedPose& pose,
            const Eigen::Matrix<double, 6, 6>& covariance) override {
    geometry_msgs_msg_dds__PoseWithCovarianceStamped_ m{};
    m.header = header(pose.t, frame);
    m.pose = poseOf(pose.T_W_B, covariance);
    write(topic, kPose, &m);
  }

  void transform(const std::string& frame, const std::string& child,
                 const StampedPose& pose) override {
    geometry_msgs_msg_dds__TransformStamped_ one{};
    const Pose& T = pose.T_W_B;
    one.header = header(pose.t, frame);
    one.child_frame_id = text(child);
    one.transform = {{T.p.x(), T.p.y(), T.p.z()}, quaternion(T.q)};
    tf2_msgs_msg_dds__TFMessage_ m{};
    m.transforms._buffer = &one;
    m.transforms._length = m.transforms._maximum = 1;
    write("/tf", kTransforms, &m);
  }

  std::vector<std::pair<std::string, long>> counters() const override {
    const std::lock_guard<std::mutex> lock(mutex_);
    return {{"messages", written_}, {"not_sent", not_written_}};
  }

 private:
  struct Channel {
    Entity topic, writer;
  };

  void write(const std::string& name, const RosType& type, const void* message) {
    const std::lock_guard<std::mutex> lock(mutex_);
    auto known = channels_.find(name);
    if (known == channels_.end()) known = channels_.emplace(name, open(name, type)).first;
    const bool written = dds_write(known->second.writer.get(), message) == DDS_RETCODE_OK;
    ++(written ? written_ : not_written_);
  }

  Channel open(const std::string& name, const RosType& type) const {
    const dds_entity_t p = domain_->participant();
    // Of topics ROS 2 has all names begin so.
    const std::string topic = "rt" + name;
    Channel out;
    out.topic =
        Entity(dds_create_topic(p, type.type, topic.c_str(), nullptr, nullptr), "topic " + topic);
    const Qos qos = newQos();
    dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, 0);
    dds_qset_durability(qos.get(), DDS_DURABILITY_VOLATILE);
    dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, kDepth);
    const std::string hash = std::string("typehash=RIHS01_") + type.hash + ";";
    dds_qset_userdata(qos.get(), hash.data(), hash.size());
    out.writer =
        Entity(dds_create_writer(p, out.topic.get(), qos.get(), nullptr), "writer of " + topic);
    return out;
  }

  std::shared_ptr<Domain> domain_;
  mutable std::mutex mutex_;
  std::map<std::string, Channel> channels_;
  long written_ = 0, not_written_ = 0;
};

}  // namespace

std::unique_ptr<RosTopics> openRosTopics(const LinkOptions& options, const LogSink& log) {
  return std::make_unique<CycloneRosTopics>(options, log);
}

}  // namespace vir::dds
