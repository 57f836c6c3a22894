#pragma once
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "vir/results/results_folder.h"
#include "vir/results/run_observer.h"
#include "vir/results/run_recorder.h"
#include "vir/roles/estimator.h"

namespace vir::runs {

struct OfflineRunOptions {
  std::string estimator;  ///< its name, for the summary
  std::string rawlog;
  std::string command;  ///< that it was called by, for the page; may be empty
  /// Observations before the first image (or odometry pose) + this are left out.
  double start_offset_s = 0;
  /// The run ends with the last observation up to this long after that; 0: with the recording.
  double duration_s = 0;
  /// What the estimator takes: images of other cameras are passed over, undecoded and counted.
  /// Empty: all images are taken.
  std::vector<roles::EstimatorInput> inputs;
  /// Labels of the recording that stand for others (input_labels.h).
  std::map<std::string, std::string> labels;
  /// In the ground truth's world; for the summary only, no estimator sees them.
  std::map<std::uint64_t, Vec3> true_anchors;
  std::map<std::uint64_t, std::string> anchor_texts;  ///< what those of a name are called
};

struct OfflineRunHooks {
  LogSink log;
  std::function<void(double)> progress;  ///< part done, 0..1; may be empty
  std::function<bool()> stop;            ///< true: end here with what there is; may be empty
  /// May change an observation before anybody sees it (a calibration from elsewhere); may be empty.
  std::function<void(mrpt::obs::CObservation*)> prepare;
  /// Asked where the result cannot be trusted and the run was not ended by `stop`: what in the
  /// recording may be the cause, the likeliest first; may be empty.
  std::function<std::vector<std::string>()> explain;
  std::vector<results::RunObserver*> observers;  ///< not owned; told in this order
};

/// Plays a rawlog to an estimator, and writes trajectory.tum,
/// trajectory_covariance.csv, trajectory_smoothed.tum, frames.csv, anchors.csv, ranges.csv,
/// landmarks.ply, map.svg, ranges.svg, scene.3Dscene and report.html; the caller writes
/// summary.json. Ground truth (label `GT`) is kept from the estimator and used for ate_* only. If
/// the estimator throws, what there is by then is written all the same and the summary's `error`
/// says why. Throws std::runtime_error if the rawlog cannot be opened or a result cannot be
/// written.
results::RunSummary runOffline(roles::Estimator& estimator, const OfflineRunOptions& options,
                               const results::ResultsFolder& folder, const OfflineRunHooks& hooks);

}  // namespace vir::runs
