#pragma once
/// Camera, IMU and ranges to states, for programs of one's own: `examples/library` is one.
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "vir/core/log.h"
#include "vir/core/settings.h"
#include "vir/estimator/loop_run.h"
#include "vir/estimator/visual_inertial_estimator.h"
#include "vir/geometry/level_transform.h"
#include "vir/types/anchor.h"
#include "vir/types/calibration.h"
#include "vir/types/image.h"
#include "vir/types/imu_sample.h"
#include "vir/types/loop_record.h"
#include "vir/types/range.h"
#include "vir/types/state.h"
#include "vir/types/survey.h"

namespace vir::estimator {

/// The estimator's settings, and those of loops and maps (docs/loops.md).
struct VioConfig : EstimatorConfig {
  VioConfig() = default;
  /// With loops, as by default.
  VioConfig(const EstimatorConfig& estimator) : EstimatorConfig(estimator) {}  // NOLINT: implicit

  LoopSettings loops;
};

/// Out of the settings of an ini, such as an importer writes beside a rawlog; of section
/// [Estimator] `loops` alone. Throws SettingsError for a value that cannot be, and for a section or
/// key that is not the estimator's.
VioConfig configFrom(const Settings& settings);

/// Settings at their defaults are those of `vir-slam run`. Readings, images and ranges may come in
/// any order against each other, each in order of its own time; a state comes out when the readings
/// have passed its image. The same input gives the same states, whatever the time of day.
///
/// Frames: W is the estimator's world, z up, smooth; M is W with what second visits have corrected,
/// or the frame of the map that was loaded once the run was found in it. Without either M is W. All
/// that comes out is in M, what its type calls W; correction() says how W lies.
class Vio {
 public:
  /// Throws std::invalid_argument that names what cannot be: a calibration without size or focal
  /// length, settings that contradict each other; std::runtime_error for a map in the settings that
  /// loadMap() would refuse.
  /// Cameras of `calibration.further` are added.
  explicit Vio(const Calibration& calibration, const VioConfig& config = {}, LogSink log = {});
  ~Vio();
  Vio(Vio&&) noexcept;
  Vio& operator=(Vio&&) noexcept;

  /// Called from within add() and finish(), once per image that was taken, in order of time;
  /// `valid` says whether there is a state. Its pose may leap where a loop is closed, and does
  /// where the run is found in a map.
  void onState(std::function<void(const StateEstimate&)> listener);
  /// Called likewise: keyframes of before are elsewhere by now, since a place was seen again.
  void onRevision(std::function<void(const Revision&)> listener);
  /// Called likewise, once per range.
  void onRange(std::function<void(const RangeRecord&)> listener);

  /// Another camera of the rig, before the first image; its number: 1, 2, ...
  int addCamera(const CameraMount& mount);

  void add(const ImuSample& sample);
  /// The pixels are copied where they have to wait. Throws std::invalid_argument for an image of
  /// another size than the calibration's, or without pixels.
  void add(const Image& image);
  void add(const Range& range);
  /// Two anchors have measured how far they are apart.
  void add(const AnchorRange& range);
  /// The input has ended: what waits is worked on.
  void finish();

  /// The run is to be looked for in this map and goes on in its frame when it was found: before the
  /// first keyframe, best before the first image. Throws std::logic_error if it comes too late, a
  /// second time or without loops, std::runtime_error naming the file if it cannot be read, is
  /// damaged or of another camera.
  void loadMap(const std::string& file);
  /// The places, anchors and map points so far, with those of the map that was loaded where the run
  /// was found in it: best after finish(). Written beside and renamed; a failure leaves what was
  /// there. Throws std::logic_error without loops, std::runtime_error naming the file, also while
  /// there is no place yet.
  void saveMap(const std::string& file) const;
  /// False as long as a map was loaded and the run was not found in it.
  bool found() const;
  /// T_M_W of the newest state: T_M_W.inverse() applied to its pose is where the estimator has it,
  /// which never leaps. Identity without loops.
  LevelTransform correction() const;
  /// Second visits, accepted or not, in order of time; none without loops.
  std::vector<LoopRecord> loops() const;

  /// Anchors ordered by id, in M.
  std::vector<Anchor> anchors() const;
  /// How the survey of the anchors (EstimatorConfig's ranges.survey) lies in M; empty without one.
  std::optional<SurveyFit> survey() const;
  /// Keyframes as the windows last saw them, in M; without loops, of hours ago not all.
  std::vector<StampedPose> keyframes() const;
  /// Map points that left the window since the start, and those in it, in M.
  std::vector<Landmark> landmarks() const;
  /// As used by now: given, or estimated on the way.
  Calibration calibration() const;
  /// What was refused or went otherwise than planned, for people.
  std::vector<std::string> warnings() const;

 private:
  /// What there is by now; `gray` (may be null): the image of `t`, which has just been added.
  void tell(TimeNs t = 0, const cv::Mat* gray = nullptr);
  LoopRun& withLoops() const;

  Calibration given_;
  std::unique_ptr<VisualInertialEstimator> estimator_;
  std::unique_ptr<LoopRun> loops_;  ///< where they are wanted
  std::function<void(const StateEstimate&)> on_state_;
  std::function<void(const Revision&)> on_revision_;
  std::function<void(const RangeRecord&)> on_range_;
};

}  // namespace vir::estimator

namespace vir {
using estimator::Vio;
}
