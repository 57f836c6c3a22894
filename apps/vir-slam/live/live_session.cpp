#include "live/live_session.h"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <mutex>
#include <optional>

#include "live/autopilot_link.h"
#include "live/foxglove_stream.h"
#include "live/live_view.h"
#include "live/pose_stream.h"
#include "live/radio_team.h"
#include "live/ros_stream.h"
#include "output/console.h"
#include "recordings/check_observer.h"
#include "robots/team_on_air.h"
#include "vir/core/ini_writer.h"
#include "vir/live/acquisition.h"
#include "vir/live/line_server.h"
#include "vir/live/live_estimation.h"
#include "vir/live/live_recorder.h"
#include "vir/rawlog/mrpt_error.h"
#include "vir/results/advice.h"

namespace vir::app {
namespace {

constexpr TimeNs kTurn = 10'000'000;  // [ns] longest wait of the main loop
constexpr std::chrono::seconds kStatusEvery(1);
constexpr double kBehindS = 1;  // of what waits to be written

using SteadyClock = std::chrono::steady_clock;

/// Lines of many threads, one after the other; warnings on the terminal as well.
LogSink consoleLog(bool verbose) {
  return [verbose](LogLevel level, const std::string& text) {
    const bool serious = level == LogLevel::warning || level == LogLevel::error;
    if (!serious && !verbose) return;
    std::fprintf(stderr, "%s%s: %s\n", isatty(STDERR_FILENO) == 1 ? "\r\033[K" : "",
                 levelName(serious ? LogLevel::warning : LogLevel::info), text.c_str());
  };
}

class LiveSession final : public results::RunObserver {
 public:
  explicit LiveSession(LiveSessionPlan& plan)
      : plan_(plan),
        options_(plan.options),
        log_(consoleLog(plan.verbose)),
        acquisition_(plan.settings, "", {}, log_),
        sensors_(acquisition_.sensors().size()) {}

  bool run() {
    rawlog::LiveRecording::requireNew(
        options_.out);  // before the sensors: what can fail at once, should
    if (options_.estimate && !options_.mavlink.port.empty()) {
      autopilot_ = std::make_unique<AutopilotLink>(options_.mavlink, log_);
    }
    openTeam();
    live::LiveMergerOptions merging;
    merging.delay = fromSeconds(options_.delay_s);
    acquisition_.start();
    startEstimation();
    // The last one is what the other robots tell.
    recorder_ =
        std::make_unique<live::LiveRecorder>(options_.out, options_.file, merging, sensors_ + 1);
    for (const std::string& line : plan_.calibration.said()) std::printf("%s\n", line.c_str());
    std::printf("recording %zu sensors to %s; Ctrl-C ends it\n", sensors_, options_.out.c_str());
    std::fflush(stdout);
    started_ = SteadyClock::now();
    loop();
    acquisition_.stop();
    pass(take(0));
    const bool sound = closeRecording();
    report();
    const bool any = anythingRecorded();
    return finishEstimation() && sound && any;
  }

  /// In the thread of the estimation.
  void onOutput(const roles::EstimatorOutput& output, const roles::Estimator& estimator) override {
    for (const StateEstimate& e : output.states) publish(e, estimator);
    for (const Revision& r : output.revisions) drawn([&] { view_->setRevision(r); });
  }

 private:
  void startEstimation() {
    if (!options_.estimate) return;
    folder_.emplace(plan_.results);
    if (options_.stream_port > 0) {
      server_ = std::make_unique<live::LineServer>(
          options_.stream_address, options_.stream_port,
          live::LineServerOptions{options_.stream_clients, options_.stream_token});
      warnOfStrangers(options_.stream_address, options_.stream_token, "Recording.stream_token");
    }
    if (options_.foxglove.port > 0) {
      foxglove_ = std::make_unique<FoxgloveStream>(options_.foxglove, plan_.usedIni());
      warnOfStrangers(options_.foxglove.address, options_.foxglove.token, "Foxglove.token");
    }
    openView();
    live::LiveEstimationHooks hooks;
    hooks.log = [this](LogLevel level, const std::string& text) {
      log_(level, text);
      if (foxglove_) foxglove_->onLog(level, text);
    };
    plan_.peers.follow(log_, &hooks.observers, [this](TimeNs t, const auto& peers) {
      if (ros_) ros_->onPeers(peers);
      if (team_) team_->onPeers(peers);
      if (!server_) return;
      for (const team::PeerResult& peer : peers) server_->send(peerLine(t, peer));
    });
    if (team_) hooks.observers.push_back(team_.get());
    if (ros_) hooks.observers.push_back(ros_.get());
    hooks.observers.push_back(&to_sensors_);
    hooks.observers.push_back(this);
    hooks.observers.push_back(&check_observer_);
    if (foxglove_) hooks.observers.push_back(foxglove_.get());
    if (server_ || autopilot_ || foxglove_) {
      hooks.on_pose = [this](const State& state, const Vec3& rate_B) {
        if (server_) server_->send(poseLine(state));
        if (autopilot_) autopilot_->send(state, rate_B);
        if (foxglove_) foxglove_->onPose(state);
      };
    }
    live::LiveEstimationOptions live;
    live.pipelined = options_.pipelined;
    estimation_ =
        std::make_unique<live::LiveEstimation>(*plan_.estimator, *folder_, live, std::move(hooks));
    results::writeTextFile(folder_->file("used.ini"), plan_.usedIni());
  }

  void openTeam() {
    if (options_.dds.robot < 0 && !options_.dds.ros2) return;
    if (!options_.estimate) {
      log_(LogLevel::warning, "[Dds] is of no use without --estimate: there is nothing to tell");
      return;
    }
    if (options_.dds.robot >= 0) {
      team_ = std::make_unique<TeamOnAir>(options_.dds, plan_.peers.label(), log_);
      team_->setListener([this](const TeamState& team) {
        if (server_) server_->send(teamLine(team));
      });
    }
    if (options_.dds.ros2) ros_ = std::make_unique<RosStream>(options_.dds, log_);
  }

  /// What sensors and other robots say.
  std::vector<live::Arrival> take(TimeNs timeout) {
    std::vector<live::Arrival> arrivals = acquisition_.take(timeout);
    if (team_) {
      team_->note(arrivals);
      for (live::Arrival& a : team_->receive(sensors_)) arrivals.push_back(std::move(a));
    }
    heard_ |= setApart(plan_.peers.label(), sensors_, &arrivals);
    return arrivals;
  }

  void warnOfStrangers(const std::string& address, const std::string& token, const char* key) {
    if (!token.empty() || address.rfind("127.", 0) == 0) return;
    log_(LogLevel::warning, "anybody who reaches " + address + " can read the poses: set " + key);
  }

  void openView() {
    if (!options_.view) return;
    try {
      view_ = openLiveView();
    } catch (const std::exception& e) {
      log_(LogLevel::warning, "no window: " + rawlog::shortReason(e));
    }
  }

  /// For the line of the terminal.
  void noteState(const StateEstimate& estimate, const roles::Estimator& estimator) {
    std::string words = healthText(estimate);
    std::string advice = results::adviceFor(estimate);
    if (advice.empty() && estimate.valid && estimate.keyframe) {
      const std::vector<Anchor> anchors = estimator.anchors();
      if (!anchors.empty()) advice = results::adviceFor(anchors);
    }
    const std::lock_guard<std::mutex> lock(state_mutex_);
    if (estimate.keyframe || !estimate.valid) advice_ = advice;
    state_ = words;
  }

  void publish(const StateEstimate& estimate, const roles::Estimator& estimator) {
    drawn([&] { view_->setEstimate(estimate, estimator); });
    noteState(estimate, estimator);
    if (autopilot_) autopilot_->setEstimate(estimate);
    if (!server_) return;
    server_->send(estimateLine(estimate));
    if (!estimate.keyframe) return;
    for (const Anchor& a : estimator.anchors()) server_->send(anchorLine(estimate.state.t, a));
    if (const auto survey = estimator.survey()) {
      server_->send(surveyLine(estimate.state.t, *survey));
    }
  }

  /// A window that fails is no reason to stop recording.
  template <typename Draw>
  void drawn(Draw draw) {
    if (!view_ || view_failed_) return;
    try {
      draw();
    } catch (const std::exception& e) {
      view_failed_ = true;
      log_(LogLevel::warning, "the window shows nothing more: " + rawlog::shortReason(e));
    }
  }

  void loop() {
    SteadyClock::time_point next_status = started_ + kStatusEvery;
    while (!interrupted() && !acquisition_.ended()) {
      pass(take(kTurn));
      const SteadyClock::time_point now = SteadyClock::now();
      if (options_.duration_s > 0 && secondsFromStart(now) >= options_.duration_s) break;
      if (!recorder_->problem().empty()) break;
      tellWhoEnded();
      tellIfBehind();
      drawn([&] { view_->draw(); });
      if (now < next_status) continue;
      next_status += kStatusEvery;
      showStatus(now);
    }
  }

  void pass(const std::vector<live::Arrival>& arrivals) {
    for (const live::Arrival& a : arrivals) {
      plan_.calibration.apply(a.observation.get());
      if (a.sensor < sensors_) check_.add(*a.observation);  // not what other robots tell
    }
    if (estimation_) estimation_->add(arrivals);
    for (const live::Arrival& a : arrivals) drawn([&] { view_->setObservation(a.observation); });
    recorder_->add(arrivals);
  }

  void tellWhoEnded() {
    const std::vector<live::SensorStatus> sensors = acquisition_.sensors();
    for (std::size_t i = 0; i < sensors.size(); ++i) {
      if (sensors[i].state != live::SensorState::running) recorder_->setEnded(i);
    }
    // What the other robots tell is put in its place while the order of time waits anyway.
    if (!team_ && !heard_) recorder_->setEnded(sensors_);
  }

  /// What waits is in memory only.
  void tellIfBehind() {
    const double behind_s = recorder_->counts().behind_s;
    if (said_behind_ || behind_s < kBehindS) return;
    said_behind_ = true;
    log_(LogLevel::warning,
         "writing cannot keep up: " + fixed(behind_s, 1) +
             " s wait in memory, and would be lost by a power failure (slower cameras, images = "
             "embed or jpg, or a faster disk)");
  }

  double secondsFromStart(SteadyClock::time_point now) const {
    return std::chrono::duration<double>(now - started_).count();
  }

  void showStatus(SteadyClock::time_point now) const {
    if (isatty(STDERR_FILENO) != 1) return;
    std::string line = fixed(secondsFromStart(now), 0) + " s";
    for (const live::SensorStatus& s : acquisition_.sensors()) {
      line += "  " + s.name + " " + std::to_string(s.observations);
      if (s.state == live::SensorState::running) continue;
      line += std::string(" (") + name(s.state) + ")";
    }
    if (estimation_) line += "  latency " + fixed(estimation_->latency().median_ms, 0) + " ms";
    {
      const std::lock_guard<std::mutex> lock(state_mutex_);
      if (!state_.empty()) line += "  " + state_;
      if (!advice_.empty()) line += "  (" + advice_ + ")";
    }
    std::fprintf(stderr, "\r\033[K%s", line.c_str());
  }

  bool closeRecording() {
    try {
      recorder_->close();
      return true;
    } catch (const std::exception& e) {
      log_(LogLevel::error, "recording ended early: " + rawlog::withoutStackTrace(e));
      return false;
    }
  }

  void report() const {
    if (isatty(STDERR_FILENO) == 1) std::fprintf(stderr, "\r\033[K");
    std::printf("%-16s %12s %9s  %s\n", "sensor", "observations", "restarts", "state");
    for (const live::SensorStatus& s : acquisition_.sensors()) {
      std::printf("%-16s %12ld %9d  %s%s%s%s\n", s.name.c_str(), s.observations, s.restarts,
                  name(s.state), s.clock_mapped ? "; stamps put on the host's clock" : "",
                  s.problem.empty() ? "" : "; last problem: ", s.problem.c_str());
    }
    for (const live::SensorStatus& s : acquisition_.sensors()) {
      for (const auto& [name, count] : s.counters) {
        if (count != 0) std::printf("%s: %s %ld\n", s.name.c_str(), name.c_str(), count);
      }
    }
    const live::LiveRecorder::Counts counts = recorder_->counts();
    std::printf("written %zu in order, %zu too late or far ahead, %zu lost\n", counts.written,
                counts.aside, counts.lost);
    if (counts.behind_s >= kBehindS) {
      std::printf("up to %.1f s waited to be written\n", counts.behind_s);
    }
    if (server_) {
      std::printf("the stream had %zu clients at the end; %ld were sent away\n", server_->clients(),
                  server_->refused());
    }
    if (autopilot_) std::printf("%s\n", autopilot_->report().c_str());
    if (team_) std::printf("%s\n", team_->report().c_str());
    if (ros_) std::printf("%s\n", ros_->report().c_str());
    if (foxglove_) std::printf("%s\n", foxglove_->report().c_str());
    for (const std::string& file : counts.files) std::printf("wrote %s\n", file.c_str());
  }

  /// Nothing at all is no recording.
  bool anythingRecorded() const {
    const live::LiveRecorder::Counts counts = recorder_->counts();
    if (counts.written + counts.aside > 0) return true;
    log_(LogLevel::error, "nothing was recorded: no sensor has said anything");
    return false;
  }

  void tellWhatTheCheckSaw() const {
    for (const std::string& line : check_observer_.lines()) std::printf("%s\n", line.c_str());
  }

  bool finishEstimation() {
    if (!estimation_) {
      tellWhatTheCheckSaw();
      return true;
    }
    results::RunSummary summary = estimation_->finish();
    summary.estimator = plan_.estimator_name;
    summary.rawlog = options_.out;
    plan_.peers.write(*folder_);
    if (team_) team_->write(*folder_);
    results::writeTextFile(folder_->file("summary.json"), toJson(summary));
    const live::Latency latency = estimation_->latency();
    std::printf("%ld images, %ld poses, %ld images left out because newer ones waited\n",
                summary.frames, summary.poses, estimation_->imagesDropped());
    std::printf("image to pose [ms]: median %.1f, 95 %% %.1f, 99 %% %.1f, longest %.1f\n",
                latency.median_ms, latency.p95_ms, latency.p99_ms, latency.max_ms);
    std::printf("verdict: %s\n", name(summary.verdict));
    for (const std::string& doubt : summary.doubts) std::printf("doubt: %s\n", doubt.c_str());
    // What it saw is among the doubts, if there are any.
    if (summary.verdict == results::Verdict::good) tellWhatTheCheckSaw();
    if (summary.ate_posyaw_m) std::printf("ATE %.4f m\n", *summary.ate_posyaw_m);
    std::printf("Results in %s\n", folder_->path().c_str());
    if (summary.poses == 0) log_(LogLevel::error, "no pose was estimated: the doubts say why");
    return summary.error.empty() && summary.poses > 0;
  }

  LiveSessionPlan& plan_;
  const RecordOptions& options_;
  LogSink log_;
  RecordingCheck check_{RecordingCheck::Depth::brief};
  CheckObserver check_observer_{check_, Settings::fromText(plan_.usedIni(), "used.ini")};
  live::Acquisition acquisition_;
  StateToSensors to_sensors_{&acquisition_};
  const std::size_t sensors_;
  std::optional<results::ResultsFolder> folder_;
  std::unique_ptr<live::LineServer> server_;
  mutable std::mutex state_mutex_;  // of what follows
  std::string state_, advice_;
  std::unique_ptr<AutopilotLink> autopilot_;
  std::unique_ptr<FoxgloveStream> foxglove_;
  std::unique_ptr<TeamOnAir> team_;
  std::unique_ptr<RosStream> ros_;
  std::unique_ptr<LiveView> view_;
  std::atomic<bool> view_failed_{false};  // asked by the thread of the estimation, so before that
  std::unique_ptr<live::LiveEstimation> estimation_;
  std::unique_ptr<live::LiveRecorder> recorder_;
  SteadyClock::time_point started_;
  bool said_behind_ = false, heard_ = false;
};

}  // namespace

std::string LiveSessionPlan::usedIni() const {
  IniWriter used(IniWriter::Style::values);
  RecordOptions recording = options;
  RunOptions running = run;
  describe(used, recording);
  describe(used, running);
  estimator->describe(used);
  peers.describe(used);
  return used.text();
}

bool runLiveSession(LiveSessionPlan* plan) { return LiveSession(*plan).run(); }

}  // namespace vir::app
