#include "live/autopilot_link.h"

#include <poll.h>

#include <algorithm>
#include <utility>

#include "output/console.h"
#include "vir/core/host_clock.h"
#include "vir/core/order_statistics.h"
#include "vir/core/resource_usage.h"

namespace vir::app {
namespace {

constexpr double kRetryS = 1, kHeartbeatS = 1;
constexpr int kWaitMs = 20;
constexpr TimeNs kOneMotion = 500'000'000;        // poses further apart say nothing of a jump
constexpr double kJumpM = 0.2, kJumpRad = 0.09;   // beyond what the last velocity explains
constexpr TimeNs kPlausibleAge = 10'000'000'000;  // older: a recording that is played
constexpr int kSure = 100, kUnsure = 25;

int qualityOf(const StateEstimate& e) {
  if (!e.valid) return -1;
  return e.health == Health::doubtful ? kUnsure : kSure;
}

}  // namespace

void describe(OptionVisitor& v, MavlinkOptions& o) {
  v.section("MAVLink", "Poses for an autopilot, while recording");
  v.value("port", o.port,
          "/dev/ttyAMA0, udp://host:port or tcp://host:port of the autopilot; empty: none");
  v.value("baud", o.baud, {1200, 4000000}, "rate of a serial port");
  v.value("rate_hz", o.rate_hz, {1, 500}, "of poses, at most the IMU's");
  v.choice("message", o.message, {"odometry", "vision_position", "both"},
           "ODOMETRY, VISION_POSITION_ESTIMATE or both");
  v.value("system", o.system, {1, 255}, "number of the vehicle that the autopilot belongs to");
  v.value("component", o.component, {1, 255}, "ours; 197 is that of visual inertial odometry");
  v.value("axes", o.axes,
          "axes of the body along the autopilot's forward, right, down; `x -y -z` for a body with "
          "x forward, y left, z up");
  v.value("position_m", o.position_m, 3, "of the autopilot in the body");
}

AutopilotLink::AutopilotLink(const MavlinkOptions& options, LogSink log)
    : options_(options),
      log_(std::move(log)),
      opener_(peerOpener(options.port, options.baud)),
      encoder_({options.system, options.component}) {
  mounting_.R_F_B = axesRotation(options.axes);
  mounting_.p_B_F = Vec3(options.position_m.data());
  thread_ = std::thread([this] { work(); });
}

AutopilotLink::~AutopilotLink() {
  stop_ = true;
  thread_.join();
}

void AutopilotLink::openAgain() {
  if (channel_ || wallSeconds() < next_try_s_) return;
  next_try_s_ = wallSeconds() + kRetryS;
  try {
    channel_ = opener_->open();
    if (told_missing_)
      vir::log(log_, LogLevel::warning, "autopilot: " + options_.port + " is there");
    told_missing_ = false;
  } catch (const DeviceError& e) {
    if (!told_missing_) {
      vir::log(log_, LogLevel::warning,
               std::string("autopilot: ") + e.what() + "; tried again every second");
    }
    told_missing_ = true;
  }
}

void AutopilotLink::listen() {
  std::uint8_t buffer[1024];
  std::string why;
  const long n = channel_->read(buffer, sizeof buffer, &why);
  if (n < 0) {
    vir::log(log_, LogLevel::warning, "autopilot: " + options_.port + ": " + why);
    told_missing_ = true;
    channel_.reset();
    return;
  }
  for (const std::int64_t ts1 : listener_.feed(buffer, static_cast<std::size_t>(n))) {
    ++asked_;
    write(encoder_.timesyncAnswer(hostNow(), ts1));
  }
}

void AutopilotLink::work() {
  double next_heartbeat_s = 0;
  while (!stop_) {
    int fd = -1;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      openAgain();
      if (channel_) listen();
      if (channel_ && wallSeconds() >= next_heartbeat_s) {
        next_heartbeat_s = wallSeconds() + kHeartbeatS;
        write(encoder_.heartbeat());
      }
      if (channel_) fd = channel_->fd();
    }
    pollfd p{fd, POLLIN, 0};  // one of -1 is passed over: then this only waits
    ::poll(&p, 1, kWaitMs);
  }
}

bool AutopilotLink::write(const std::string& frame) {
  return channel_ &&
         channel_->write(reinterpret_cast<const std::uint8_t*>(frame.data()), frame.size());
}

void AutopilotLink::setEstimate(const StateEstimate& e) {
  const std::lock_guard<std::mutex> lock(mutex_);
  quality_ = qualityOf(e);
  if (!e.valid) return;
  covariance_ = e.covariance;
  if (segment_ && *segment_ != e.segment) {
    ++resets_;
    last_.reset();
  }
  segment_ = e.segment;
}

/// The world's frame can move under the robot: an anchor is found, a loop closed.
void AutopilotLink::noteJump(const State& state, const Vec3& rate_B) {
  if (last_ && state.t - last_->t < kOneMotion) {
    const double dt = toSeconds(state.t - last_->t);
    const Vec3 expected = last_->T_W_B.p + 0.5 * dt * (last_->v + state.v);
    const Quat turned = last_->T_W_B.q * expQuat(0.5 * dt * (last_rate_ + rate_B));
    if ((state.T_W_B.p - expected).norm() > kJumpM ||
        turned.angularDistance(state.T_W_B.q) > kJumpRad) {
      ++resets_;
    }
  }
  last_ = state;
  last_rate_ = rate_B;
}

void AutopilotLink::send(const State& state, const Vec3& rate_B) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (state.t < next_ && next_ - state.t < kOneMotion) return;
  const auto period = fromSeconds(1 / options_.rate_hz);
  next_ = state.t - next_ < period ? next_ + period : state.t + period;
  noteJump(state, rate_B);
  live::MavlinkPose pose = live::autopilotPose(state, rate_B, covariance_, mounting_);
  pose.resets = resets_;
  pose.quality = quality_;
  bool taken = true;
  if (options_.message != "vision_position") taken = write(encoder_.odometry(pose)) && taken;
  if (options_.message != "odometry") taken = write(encoder_.visionPosition(pose)) && taken;
  ++(taken ? sent_ : lost_);
  const TimeNs age = hostNow() - state.t;
  if (taken && age >= 0 && age < kPlausibleAge)
    age_ms_.push_back(static_cast<float>(1e3 * toSeconds(age)));
}

std::string AutopilotLink::report() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  std::string line = "autopilot on " + options_.port + ": " + std::to_string(sent_) +
                     " poses sent, " + std::to_string(lost_) + " not taken, " +
                     std::to_string(resets_) + " resets, " + std::to_string(asked_) +
                     " questions for the time";
  if (age_ms_.empty()) return line;
  std::vector<float> all = age_ms_;
  line +=
      "; age when sent [ms]: median " + fixed(static_cast<double>(quantileInPlace(&all, 0.5)), 1);
  return line + ", 95 % " + fixed(static_cast<double>(quantileInPlace(&all, 0.95)), 1);
}

}  // namespace vir::app
