#pragma once
/// Between the estimator and who takes its states, where second visits are looked for: keyframes to
/// the loop closer, and what it corrects into the states. The estimator hears nothing of it.
#include <deque>
#include <memory>
#include <mutex>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "vir/estimator/visual_inertial_estimator.h"
#include "vir/mission/loop_closer.h"
#include "vir/types/frame_change.h"

namespace vir::estimator {

class LoopWorker;
struct LoopAnswer;

struct LoopSettings {
  bool use = true;       ///< [Estimator] loops
  std::string map;       ///< file to begin with; empty: none
  std::string save_map;  ///< file to write at the end; empty: none
  mission::LoopOptions options;

  bool hasMaps() const { return !map.empty() || !save_map.empty(); }
};
/// `loops` of the section at hand.
void describeUse(OptionVisitor& v, LoopSettings& o);
/// Sections [Loops] and below.
void describe(OptionVisitor& v, LoopSettings& o);

/// What became known since it was last asked, oldest first; in M but for `uncorrected`.
struct LoopedOutput {
  std::vector<StateEstimate> states;
  std::vector<RangeRecord> ranges;
  std::vector<Revision> revisions;
  std::vector<StampedPose> uncorrected;    ///< of the valid states, in W
  std::vector<FrameChange> frame_changes;  ///< where the run was found in the map: W, then M
};

/// When what loops tell counts: with the next state, or some images later, so that whoever waits
/// for poses never waits for loops. The results are those of `late` with and without a thread.
enum class LoopTiming { at_once, late, in_a_thread };

class LoopRun {
 public:
  /// Reads the map. Throws std::invalid_argument for options, std::runtime_error naming the file.
  explicit LoopRun(const LoopSettings& settings, LogSink log = {},
                   LoopTiming timing = LoopTiming::at_once);
  ~LoopRun();

  /// The run is to be looked for in this map. Throws std::logic_error where keyframes were taken or
  /// a map was loaded already, and std::runtime_error, naming the file, for one that cannot be read
  /// or is of another camera.
  void loadMap(const std::string& file);
  /// Throws std::runtime_error if the map is of another camera.
  void setCamera(const Calibration& calibration);
  /// An image that may become a keyframe. Its pixels are shared, which nobody may change from now
  /// on; they are copied only if `gray` does not own them. From any thread.
  void keep(TimeNs t, const cv::Mat& gray);
  /// The estimator's states since the last call, which become those of the mission. `gray` (may be
  /// null): the image of `t`, which was not kept; it is where its state is still to come.
  LoopedOutput take(VisualInertialEstimator* estimator, TimeNs t, const cv::Mat* gray);
  /// The last solution, and the map to the file of the settings; a run that saw no place, or was
  /// not found in the map of that very file, warns and leaves that as it is. Throws
  /// std::runtime_error naming it.
  void finish(const VisualInertialEstimator& estimator);
  /// The map so far (docs/loops.md). Throws std::runtime_error naming the file, also while there is
  /// no place yet.
  void saveMap(const VisualInertialEstimator& estimator, const std::string& file) const;

  /// False as long as a map was loaded and the run was not found in it.
  bool found() const { return found_; }
  /// T_M_W of the newest pose.
  LevelTransform correction() const { return correction_.T_M_W; }
  std::vector<StampedPose> keyframes(const VisualInertialEstimator& estimator) const;
  std::vector<Anchor> anchors(std::vector<Anchor> in_W) const;
  std::optional<SurveyFit> survey(std::optional<SurveyFit> of_W) const;
  /// In M: the estimator's, or once a loop acts those of the keyframes, which move with them.
  std::vector<Landmark> landmarks(const VisualInertialEstimator& estimator) const;
  std::vector<LoopRecord> records() const;
  std::vector<std::pair<std::string, long>> counters() const;
  std::vector<std::string> warnings() const;  ///< for people

 private:
  struct Kept {
    TimeNs t;
    cv::Mat gray;
  };
  /// The image of `t` and all before it go; empty if it is not there.
  cv::Mat release(TimeNs t);
  /// An image before the first pose, which may tell where that is.
  void keepEarly(TimeNs t, const cv::Mat& gray);
  /// Keyframes that the estimator began with: `first` is the first state.
  void lookBack(const StateEstimate& first, const VisualInertialEstimator& estimator);
  void see(const StateEstimate& estimate, const KeyframeSights& sights, const cv::Mat& gray,
           const VisualInertialEstimator& estimator);
  void hear(LoopAnswer answer, std::vector<Revision>* revisions);
  /// Once: where the frame changes.
  void tellFound(TimeNs t, LoopedOutput* out);
  std::string notFound() const;
  std::string nothingToSave() const;
  /// Empty before the camera is known.
  mission::MissionMap mapNow(const VisualInertialEstimator& estimator) const;
  /// Of what was loaded, with the camera. Throws std::runtime_error if it is of another one.
  void begin();

  LoopSettings settings_;
  LogSink log_;
  LoopTiming timing_;
  std::string map_file_;
  std::optional<mission::MissionMap> map_;
  std::unique_ptr<LoopWorker> worker_;
  mission::KeyframePace pace_;
  mission::Correction correction_;  ///< as far as answers count by now
  bool found_ = true;
  std::vector<Revision> last_revisions_;
  long image_ = 0;    ///< of the states so far
  std::mutex mutex_;  // of kept_
  std::deque<Kept> kept_;
  std::deque<Kept> early_;
  std::vector<FollowedPose> settled_;  ///< that the worker was not told of yet
  bool finished_ = false;
  bool saved_ = false;
  std::string not_saved_;    // why; empty: nothing was to be, or it is
  bool told_found_ = false;  // as a change of frame
  int segment_ = 0;
  TimeNs segment_since_ = 0, newest_ = 0;
};

}  // namespace vir::estimator
