#pragma once
/// Camera, IMU and ranges to states, for programs of one's own: `examples/library` is one.
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "vir/core/log.h"
#include "vir/core/settings.h"
#include "vir/estimator/visual_inertial_estimator.h"
#include "vir/types/anchor.h"
#include "vir/types/calibration.h"
#include "vir/types/image.h"
#include "vir/types/imu_sample.h"
#include "vir/types/range.h"
#include "vir/types/state.h"
#include "vir/types/survey.h"

namespace vir::estimator {

/// Out of the settings of an ini, such as an importer writes beside a rawlog. Throws SettingsError
/// for a value that cannot be, and for a section or key that is not the estimator's.
EstimatorConfig configFrom(const Settings& settings);

/// Settings at their defaults are those of `vir-slam run`. Readings, images and ranges may come in
/// any order against each other, each in order of its own time; a state comes out when the readings
/// have passed its image. The same input gives the same states, whatever the time of day.
class Vio {
 public:
  /// Throws std::invalid_argument that names what cannot be: a calibration without size or focal
  /// length, settings that contradict each other.
  /// Cameras of `calibration.further` are added.
  explicit Vio(const Calibration& calibration, const EstimatorConfig& config = {},
               LogSink log = {});
  ~Vio();
  Vio(Vio&&) noexcept;
  Vio& operator=(Vio&&) noexcept;

  /// Called from within add() and finish(), once per image that was taken, in order of time;
  /// `valid` says whether there is a state.
  void onState(std::function<void(const StateEstimate&)> listener);
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

  /// Anchors ordered by id, in W.
  std::vector<Anchor> anchors() const;
  /// How the survey of the anchors (EstimatorConfig's ranges.survey) lies in W; empty without one.
  std::optional<SurveyFit> survey() const;
  /// Keyframes as the windows last saw them, in W; of hours ago not all.
  std::vector<StampedPose> keyframes() const;
  /// Map points that left the window since the start, and those in it, in W.
  std::vector<Landmark> landmarks() const;
  /// As used by now: given, or estimated on the way.
  Calibration calibration() const;
  /// What was refused or went otherwise than planned, for people.
  std::vector<std::string> warnings() const;

 private:
  void tell();

  Calibration given_;
  std::unique_ptr<VisualInertialEstimator> estimator_;
  std::function<void(const StateEstimate&)> on_state_;
  std::function<void(const RangeRecord&)> on_range_;
};

}  // namespace vir::estimator

namespace vir {
using estimator::Vio;
}
