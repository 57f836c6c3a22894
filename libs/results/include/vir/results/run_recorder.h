#pragma once
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "vir/evaluation/evaluate.h"
#include "vir/evaluation/trajectory.h"
#include "vir/results/results_folder.h"
#include "vir/results/run_observer.h"
#include "vir/roles/estimator.h"
#include "vir/team/peer_result.h"

namespace vir::results {

class FrameHistory;
class RangeRecorder;
class LoopRecorder;
class LongRun;
class Thumbnails;
struct FrameError;

/// An anchor at the end of a run.
struct AnchorResult {
  Anchor estimate;
  /// Distance to where it truly is, by the alignment of the causal trajectory to the ground truth;
  /// empty where either is not known. `horizontal`: without the height.
  std::optional<double> error_m, error_horizontal_m;
  std::string called;  ///< in the recording; empty: by its number
  /// For people.
  std::string title() const { return called.empty() ? std::to_string(estimate.id) : called; }
};

/// What a run amounts to: the content of summary.json.
/// Can the result be trusted?
enum class Verdict {
  good,
  doubtful,  ///< there are poses, and RunSummary::doubts says what speaks against them
  lost,      ///< no pose, or none for most of the time
};
const char* name(Verdict verdict);

/// Kinds of data, in the words of a doubt.
constexpr const char *kImages = "images", *kImuReadings = "readings of the IMU",
                     *kRanges = "ranges", *kOdometryPoses = "poses of the odometry";

struct RunSummary {
  std::string estimator, rawlog;
  std::string command;  ///< that it was called by, for report.html; may be empty
  long frames = 0;      ///< images handed to the estimator; odometry poses if there are no images
  long poses = 0;       ///< lines of trajectory.tum
  std::optional<double> init_time_s;  ///< first pose after the first frame; empty: never
  /// First pose in the frame of a map, after the first frame; empty: no map, or not found in it.
  std::optional<double> in_map_s;
  double duration_s = 0;  ///< first to last frame
  double path_m = 0;      ///< length of the estimated path, changes of frame left out
  double wall_s = 0, cpu_s = 0;
  double cpu_ms_per_frame = 0;  ///< CPU time inside the estimator per frame, decoding not included
  double peak_rss_mb = 0;
  /// Position + yaw aligned RMSE of the causal and the smoothed trajectory, where there is ground
  /// truth for them.
  std::optional<double> ate_posyaw_m, ate_posyaw_deg, ate_smoothed_posyaw_m;
  /// Relative error of the causal trajectory: rms over pieces of 1 s and of 10 m of path. Empty
  /// where there is no piece of that length.
  std::optional<double> rpe_1s_m, rpe_1s_deg, rpe_10m_m, rpe_10m_deg;
  /// Mean normalised squared error of the causal positions per axis, in the world of the first
  /// keyframe; 1 = the covariances tell the truth, above = too sure.
  std::optional<double> nees_position;
  std::vector<AnchorResult> anchors;  ///< ordered by id
  /// Ranges by what became of them: used, kept for an anchor without a position, not used.
  long ranges_accepted = 0, ranges_collected = 0, ranges_rejected = 0;
  long ranges_before_start = 0;  ///< before there was a pose to hang them on
  /// Second visits; empty if they were not looked for.
  std::optional<std::pair<long, long>> loops;  ///< accepted, rejected
  std::optional<SurveyFit> survey;             ///< of the anchors, if one was given
  std::vector<team::PeerResult> peers;         ///< other robots, ordered by id
  int resets = 0;
  bool interrupted = false;
  bool damaged = false;  ///< the recording ends in damage or was cut off
  std::string longest_wait_reason;
  std::optional<Calibration> calibration;             ///< of camera and IMU, as used in the end
  std::vector<std::string> further_labels = {};       ///< of its further cameras
  std::optional<CalibrationSigma> calibration_sigma;  ///< if it was estimated
  std::vector<CalibrationSigma> further_sigma = {};   ///< likewise, of the further cameras
  std::optional<CalibrationCovariance> calibration_covariance;
  std::optional<Calibration> calibration_given;         ///< what the run began with
  std::optional<CalibrationSigma> calibration_assumed;  ///< how far that was taken to be off
  /// What was left out before the estimator saw it, by kind (kImages, ...).
  std::map<std::string, long> left_out;
  std::vector<std::string> doubts;          ///< what speaks against the result
  std::vector<std::string> unusable_input;  ///< what makes a sensor's data useless: doubts always
  std::vector<std::string> likely_causes;   ///< seen in the input: doubts where there are others
  Verdict verdict = Verdict::lost;
  std::string error;  ///< what ended the run early; empty if nothing did
  std::vector<std::pair<std::string, long>> counters;
  std::vector<std::string> warnings;
};

/// What an estimator says of itself at the end becomes the summary's; counters and warnings are
/// added to those that are there.
void takeReport(const roles::EstimatorReport& report, RunSummary* summary);
/// Adds the doubts that only a whole run can raise, and fills in the verdict. Where it is not good,
/// `explain` (may be empty) is asked for likely causes, which go before those that are there.
void fillVerdict(RunSummary* summary,
                 const std::function<std::vector<std::string>()>& explain = {});

/// summary.json.
std::string toJson(const RunSummary& summary);

/// Writes the result files of an estimator as it goes.
class RunRecorder final : public RunObserver {
 public:
  /// Throws std::runtime_error if a file cannot be created.
  RunRecorder(const ResultsFolder& folder, LogSink log);
  ~RunRecorder() override;

  /// Images, for the small pictures of report.html. They are to live until their onOutput().
  void onObservation(const mrpt::obs::CObservation& observation) override;
  void onOutput(const roles::EstimatorOutput& output, const roles::Estimator& estimator) override;
  /// A pose of the reference trajectory, in time order.
  void addGroundTruth(TimeNs t, const Pose& T_W_B);
  /// Where anchors truly are, in the world of the ground truth; compared with at the end only.
  /// What anchors are called that have no number of their own.
  void setAnchorTexts(std::map<std::uint64_t, std::string> texts) { texts_ = std::move(texts); }
  void setTrueAnchors(std::map<std::uint64_t, Vec3> anchors) { true_anchors_ = std::move(anchors); }
  /// Stamp of the first image (or odometry pose): what `init_time_s` and pictures count from.
  void setFirstFrame(TimeNs t) { first_frame_ = t; }
  /// What to ask for causes at the end if the result cannot be trusted; see fillVerdict().
  void setExplanation(std::function<std::vector<std::string>()> explain) {
    explain_ = std::move(explain);
  }
  /// Writes what only the end of the run knows, closes the files and fills in the summary's poses,
  /// path, ate_*, anchors, ranges_* and counters of its own. The pictures and report.html show the
  /// summary as it is then. Throws std::runtime_error if anything could not be written.
  void onEnd(const roles::Estimator& estimator, RunSummary* summary) override;

 private:
  void add(const StateEstimate& estimate);
  void add(const Revision& revision);
  /// Whatever was written of the causal path so far is of another frame.
  void add(const FrameChange& change);
  void keepSettled(const StampedPose& keyframe);
  void writePose(const StateEstimate& estimate);
  void fetchLongRun();
  void writeKeyframes(const std::vector<StampedPose>& keyframes);
  void writeLandmarks(const std::vector<Landmark>& landmarks);
  void checkGroundTruth(RunSummary* summary);
  void takeSurvey(const roles::Estimator& estimator, RunSummary* summary);
  void evaluateInto(RunSummary* summary);
  std::vector<FrameError> errorsFromStart() const;
  std::optional<double> positionNees(const std::vector<FrameError>& errors) const;
  void writePictures(const std::vector<Anchor>& anchors, const std::vector<Landmark>& landmarks,
                     const RunSummary& summary) const;
  void summariseRanges(RunSummary* summary) const;

  const ResultsFolder& folder_;
  LogSink log_;
  OutputFile trajectory_file_, covariance_file_, frames_file_;
  std::unique_ptr<RangeRecorder> ranges_;
  std::unique_ptr<LoopRecorder> loops_;
  std::unique_ptr<LongRun> long_run_;  // what grows with the run, until its end
  std::unique_ptr<FrameHistory> history_;
  std::unique_ptr<Thumbnails> images_;
  TimeNs first_frame_ = 0;
  std::map<TimeNs, Pose> revised_;    // keyframes as they were last told of, until they settle
  std::vector<FrameChange> to_come_;  // of the frame: of states that were not added yet
  std::vector<FrameChange> frame_changes_;  // that were written
  std::optional<StampedPose> last_pose_;
  std::optional<TimeNs> first_estimate_;
  TimeNs last_truth_ = 0;
  // From the end of the run on:
  Trajectory trajectory_, smoothed_, truth_;
  std::map<std::uint64_t, std::string> texts_;
  std::map<std::uint64_t, Vec3> true_anchors_;
  std::function<std::vector<std::string>()> explain_;
  std::optional<evaluation::EvaluationResult> evaluation_;  // of the causal trajectory
  std::vector<double> position_sigma_m_;                    // per pose of it
  std::vector<Mat3> position_covariance_;                   // the same
  std::vector<FrameError> errors_;                          // of those with a truth
  std::vector<std::pair<TimeNs, double>> cpu_ms_;           // per frame
  double path_m_ = 0;
  int segment_ = 0;
  long not_finite_ = 0, out_of_order_ = 0;
};

}  // namespace vir::results
