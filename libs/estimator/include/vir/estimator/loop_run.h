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
#include "vir/roles/estimator.h"

namespace vir {

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

class LoopRun {
 public:
  /// Reads the map. Throws std::runtime_error naming the file.
  LoopRun(const LoopSettings& settings, LogSink log);

  /// Throws std::runtime_error if the map is of another camera.
  void setCamera(const Calibration& calibration);
  /// An image that may become a keyframe. Its pixels are shared, which nobody may change from now
  /// on; they are copied only if `gray` does not own them. From any thread.
  void keep(TimeNs t, const cv::Mat& gray);
  /// The estimator's states since the last call, which become those of the mission. `gray` (may be
  /// null): the image of `t`, which was not kept.
  roles::EstimatorOutput take(estimator::VisualInertialEstimator* estimator, TimeNs t,
                              const cv::Mat* gray);
  /// The last solution, and the map to its file. Throws std::runtime_error naming it.
  void finish(const estimator::VisualInertialEstimator& estimator);

  std::vector<StampedPose> keyframes(const estimator::VisualInertialEstimator& estimator) const;
  std::vector<Anchor> anchors(std::vector<Anchor> in_W) const;
  std::optional<SurveyFit> survey(std::optional<SurveyFit> of_W) const;
  /// In M: the estimator's, or once a loop acts those of the keyframes, which move with them.
  std::vector<Landmark> landmarks(const estimator::VisualInertialEstimator& estimator) const;
  std::vector<LoopRecord> records() const;
  void report(roles::EstimatorReport* report) const;

 private:
  struct Kept {
    TimeNs t;
    cv::Mat gray;
  };
  /// The image of `t` and all before it go; empty if it is not there.
  cv::Mat release(TimeNs t);
  void see(const StateEstimate& estimate, const estimator::KeyframeSights& sights,
           const cv::Mat& gray, const estimator::VisualInertialEstimator& estimator);
  std::string notFound() const;
  void solve(const estimator::VisualInertialEstimator& estimator);
  /// Its keyframes, those included that have left its windows.
  std::vector<StampedPose> inWorld(const estimator::VisualInertialEstimator& estimator) const;

  LoopSettings settings_;
  LogSink log_;
  std::optional<mission::MissionMap> map_;
  std::unique_ptr<mission::LoopCloser> closer_;
  std::mutex mutex_;  // of kept_
  std::deque<Kept> kept_;
  std::vector<StampedPose> settled_;  // in W
  std::optional<Revision> last_revision_;
  bool saved_ = false;
  int segment_ = 0;
  TimeNs segment_since_ = 0;
};

}  // namespace vir
