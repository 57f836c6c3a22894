#pragma once
/// Poses to an autopilot by MAVLink (docs/autopilot.md), while recording.
#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "byte_source.h"
#include "vir/core/log.h"
#include "vir/core/options.h"
#include "vir/live/mavlink_messages.h"

namespace vir::app {

/// Section [MAVLink] of a live ini.
struct MavlinkOptions {
  std::string port;  ///< empty: nothing is sent
  int baud = 921600;
  double rate_hz = 50;
  std::string message = "odometry";
  int system = 1, component = 197;
  std::string axes = "x -y -z";
  std::vector<double> position_m = {0, 0, 0};
};

void describe(OptionVisitor& v, MavlinkOptions& o);

/// Sends poses, a heartbeat a second, and answers questions for the time. A device that is not
/// there, or goes away, is opened again every second; poses of that time are lost, and counted.
class AutopilotLink {
 public:
  /// Throws DeviceError or std::invalid_argument for a port or axes that cannot be.
  AutopilotLink(const MavlinkOptions& options, LogSink log);
  ~AutopilotLink();
  AutopilotLink(const AutopilotLink&) = delete;
  AutopilotLink& operator=(const AutopilotLink&) = delete;

  /// What the estimator says of an image: how sure it is, and whether it had to start anew. Any
  /// thread.
  void setEstimate(const StateEstimate& estimate);
  /// A pose per reading of the IMU; those beyond `rate_hz` pass. Any thread.
  void send(const State& state, const Vec3& rate_B);
  /// "autopilot on PORT: ...": poses sent and lost, their age, what was asked.
  std::string report() const;

 private:
  void work();
  void openAgain();
  void listen();
  bool write(const std::string& frame);
  void noteJump(const State& state, const Vec3& rate_B);

  const MavlinkOptions options_;
  live::AutopilotMounting mounting_;
  LogSink log_;
  std::unique_ptr<ChannelOpener> opener_;
  live::TimesyncListener listener_;

  mutable std::mutex mutex_;  // of what follows
  live::MavlinkEncoder encoder_;
  std::unique_ptr<ByteChannel> channel_;
  Eigen::Matrix<double, 6, 6> covariance_ = Eigen::Matrix<double, 6, 6>::Zero();
  std::optional<int> segment_;
  int resets_ = 0, quality_ = 0;
  std::optional<State> last_;  // that was sent
  Vec3 last_rate_ = Vec3::Zero();
  TimeNs next_ = 0;
  long sent_ = 0, lost_ = 0, asked_ = 0;
  std::vector<float> age_ms_;

  double next_try_s_ = 0;
  bool told_missing_ = false;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace vir::app
