#pragma once
#include <condition_variable>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "vir/live/acquisition.h"
#include "vir/live/latency.h"
#include "vir/live/pose_propagator.h"
#include "vir/results/results_folder.h"
#include "vir/results/run_recorder.h"
#include "vir/roles/estimator.h"

namespace vir::live {

struct LiveEstimationOptions {
  /// Images that may wait while one is worked on; beyond that the oldest waiting goes, so that the
  /// pose is always of a new image.
  std::size_t waiting_images = 2;
  /// Tracking and optimisation in a thread each, where the estimator can.
  bool pipelined = true;
};

struct LiveEstimationHooks {
  LogSink log;
  /// Per reading of the IMU, in the thread that calls add(); with the rate of turning about the
  /// body's axes [rad/s], its bias taken off.
  std::function<void(const State&, const Vec3& rate_B)> on_pose;
  /// Not owned. onOutput() comes from the thread that made the estimates; no two calls at a time.
  std::vector<results::RunObserver*> observers;
};

/// Estimates while sensors deliver, in one or two threads of its own, and writes the files of a
/// run.
class LiveEstimation {
 public:
  /// `settings` have been read. Throws like RunRecorder and EstimatorSettings::create().
  LiveEstimation(roles::EstimatorSettings& settings, const results::ResultsFolder& folder,
                 const LiveEstimationOptions& options, LiveEstimationHooks hooks);
  ~LiveEstimation();

  /// What came in, in order of arrival.
  void add(const std::vector<Arrival>& arrivals);
  /// Are there two threads?
  bool pipelined() const { return behind_; }
  /// Works through what waits, ends the estimator and writes what only the end knows.
  results::RunSummary finish();

  Latency latency() const;
  /// Images left out because newer ones waited.
  long imagesDropped() const;
  /// Why estimating ended early; empty if it did not.
  std::string problem() const;

 private:
  /// By the estimator, or by an observer (which is not told of images that the estimator passes
  /// over).
  bool followed(const mrpt::obs::CObservation& observation) const;
  void work();
  void handle(const Arrival& arrival);
  void collect();
  void propagate(const Arrival& arrival);
  void fail(const std::exception& e);

  std::vector<roles::EstimatorInput> inputs_;
  std::unique_ptr<roles::Estimator> estimator_;
  LiveEstimationOptions options_;
  LiveEstimationHooks hooks_;
  results::RunRecorder recorder_;
  PosePropagator propagator_;
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<Arrival> queue_;
  std::map<std::string, std::size_t> waiting_images_;  ///< per camera
  long dropped_ = 0;
  bool closing_ = false;
  std::string problem_;
  LatencyCounter latencies_;
  std::mutex results_mutex_;           // of the recorder and:
  std::map<TimeNs, TimeNs> arrivals_;  // of images handed to the estimator, by stamp
  double estimate_ms_ = 0;
  results::RunSummary summary_;  // of the thread
  bool behind_ = false, finished_ = false;
  std::optional<TimeNs> first_frame_;
  TimeNs last_frame_ = 0;
  double cpu_s_ = 0, wall_from_ = 0;
  std::thread thread_;
};

}  // namespace vir::live
