#pragma once
/// Role "estimator": observations in time order in, a state estimate per image out.
#include <mrpt/obs/CObservation.h>

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "vir/core/log.h"
#include "vir/core/options.h"
#include "vir/types/anchor.h"
#include "vir/types/calibration_change.h"
#include "vir/types/frame_change.h"
#include "vir/types/loop_record.h"
#include "vir/types/range.h"
#include "vir/types/state.h"
#include "vir/types/survey.h"

namespace vir::roles {

/// What kind of observation; docs/recordings.md has the classes.
enum class InputKind { image, tracks, imu, ranges, pose };
const char* name(InputKind kind);

/// Observations that an estimator takes.
struct EstimatorInput {
  InputKind kind = InputKind::image;
  std::string label;
  /// 0 = used where there are any. Of the inputs with the same number above 0 at least one is
  /// needed: images or feature tracks, say.
  int group = 0;
  /// Somebody asked for this camera by its label: if it is not there, that must be said.
  bool named = false;
};

/// Is `observation` of this input, by label and class?
bool matches(const EstimatorInput& input, const mrpt::obs::CObservation& observation);
/// Does any of `inputs` match, or is it of an anchor put down by the robot (label `ANCHOR:<id>`),
/// or a difference of ranges (`TDOA:<id>`)?
bool takes(const std::vector<EstimatorInput>& inputs, const mrpt::obs::CObservation& observation);
/// Is it of a camera beside the first among the inputs? States are of images of the first.
bool isOfFurtherCamera(const std::vector<EstimatorInput>& inputs,
                       const mrpt::obs::CObservation& observation);

/// Counted, never silent: what the estimator could not use, and what happened to it.
struct EstimatorReport {
  std::vector<std::pair<std::string, long>> counters;  ///< e.g. {"images_unusable", 3}
  std::vector<std::string> warnings;
  int resets = 0;
  std::string longest_wait_reason;  ///< why initialisation took as long as it did
  std::vector<std::string> doubts;  ///< what speaks against the states; a kind each
  std::optional<CalibrationSigma> calibration_sigma;            ///< if it was estimated
  std::optional<CalibrationCovariance> calibration_covariance;  ///< the same in full
  std::optional<Calibration> calibration;  ///< as used in the end: given, or estimated on the way
  std::vector<std::string> further_labels = {};      ///< of the recording, of Calibration::further
  std::vector<CalibrationSigma> further_sigma = {};  ///< of these cameras, if it was estimated
  std::optional<Calibration> calibration_given;      ///< what it began with
  std::optional<CalibrationSigma> calibration_assumed;  ///< how far that was taken to be off
};

/// The calibration as known at one frame.
struct CalibrationPoint {
  TimeNs t = 0;
  Calibration calibration;
  CalibrationSigma sigma;
};

/// What became known since it was last asked, oldest first.
struct EstimatorOutput {
  std::vector<StateEstimate> states;
  std::vector<RangeRecord> ranges;
  std::vector<Revision> revisions;
  std::vector<CalibrationPoint> calibrations;  ///< only of what is estimated
  /// Keyframes that will not change any more. Whoever wants all of a long run keeps them from here.
  std::vector<StampedPose> settled{};
  /// Poses of the valid states without what loops have corrected: smooth. None without loops.
  std::vector<StampedPose> uncorrected = {};
  /// Of `states`, as where the run was found in a map.
  std::vector<FrameChange> frame_changes = {};
};

/// A working estimator. The caller keeps time order per sensor.
class Estimator {
 public:
  virtual ~Estimator() = default;
  /// One observation that takes() lets through; others are passed over. Must not keep a reference
  /// to the image after it returns unless it copies it.
  virtual void add(const mrpt::obs::CObservation& observation) = 0;
  /// The input has ended: process what is queued.
  virtual void finish() = 0;
  virtual EstimatorOutput take() = 0;
  /// Map points that left the window since the start, and those in it; in a long run not all.
  virtual std::vector<Landmark> landmarks() const = 0;
  /// Keyframes as the window last saw them; of hours ago not all.
  virtual std::vector<StampedPose> keyframes() const = 0;
  /// Anchors ordered by id; none if the estimator uses no ranges.
  virtual std::vector<Anchor> anchors() const { return {}; }
  /// How a survey of the anchors lies in W; empty without one.
  virtual std::optional<SurveyFit> survey() const { return std::nullopt; }
  /// Second visits that were looked for, in order of time; nothing if they were not.
  virtual std::optional<std::vector<LoopRecord>> loops() const { return std::nullopt; }
  /// Where features were seen in the last image [px]; none if the estimator uses no images.
  virtual std::vector<Eigen::Vector2f> trackedPixels() const { return {}; }
  virtual EstimatorReport report() const = 0;
};

/// The settings of an estimator, which can make one.
class EstimatorSettings {
 public:
  virtual ~EstimatorSettings() = default;
  /// Declares the settings, in the sections that are the estimator's own.
  virtual void describe(OptionVisitor& v) = 0;
  /// What it takes with the settings as they are now.
  virtual std::vector<EstimatorInput> inputs() const = 0;
  /// Along -z of W [m/s^2]: what its states are to be carried on with.
  virtual double gravity() const { return 9.81; }
  /// Live use: what create() makes from now on works on in a thread of its own when add() has
  /// returned, and calls `on_estimates` from there when there is something to take. In that call
  /// all but report() may be asked, and everything after finish(), which ends the calls even if it
  /// throws; at other times only add() and finish() may be called. False: it has no such thread,
  /// and works in add().
  virtual bool workBehind() { return false; }
  /// Throws std::exception with what is wrong and what to do: files that cannot be read, settings
  /// that contradict each other.
  virtual std::unique_ptr<Estimator> create(const LogSink& log,
                                            std::function<void()> on_estimates = {}) const = 0;
};

}  // namespace vir::roles
