#pragma once
/// Estimator plugin `vir`: MRPT observations to the visual-inertial estimator and back.
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tracks_of.h"
#include "vir/estimator/loop_run.h"
#include "vir/estimator/visual_inertial_estimator.h"
#include "vir/imu/saturation.h"
#include "vir/rawlog/labels.h"
#include "vir/roles/estimator.h"

namespace mrpt::img {
class TCamera;
}
namespace mrpt::poses {
class CPose3D;
}
namespace mrpt::obs {
class CObservationImage;
class CObservationIMU;
class CObservationStereoImagesFeatures;
}  // namespace mrpt::obs

namespace vir {

class VirSettings final : public roles::EstimatorSettings {
 public:
  void describe(OptionVisitor& v) override;
  std::vector<roles::EstimatorInput> inputs() const override;
  double gravity() const override { return config.imu.gravity_mps2; }
  bool workBehind() override;
  std::unique_ptr<roles::Estimator> create(const LogSink& log,
                                           std::function<void()> on_estimates) const override;

  estimator::EstimatorConfig config;
  estimator::LoopSettings loops;
  /// Of the cameras beside the first, in the order of their numbers in the rig.
  std::vector<std::string> otherCameraLabels() const;

  /// Throws std::invalid_argument if a camera is named twice, or the first one as another.
  void requireOtherCameras() const;

  std::string camera_label = rawlog::kCameraLabel;
  std::string other_cameras = "none";
  std::string tracks_label = rawlog::kTracksLabel;
  std::string imu_label = rawlog::kImuLabel;
  std::string range_label = rawlog::kRangeLabel;
  std::vector<double> other_time_offsets_s;
};

class VirEstimator final : public roles::Estimator {
 public:
  /// With `on_estimates` it works on in a thread of its own. Throws std::runtime_error if a file
  /// that the settings name cannot be read.
  VirEstimator(VirSettings settings, const LogSink& log, std::function<void()> on_estimates);

  void add(const mrpt::obs::CObservation& observation) override;
  void finish() override;
  roles::EstimatorOutput take() override;
  std::vector<Landmark> landmarks() const override;
  std::vector<StampedPose> keyframes() const override;
  std::vector<Anchor> anchors() const override;
  std::optional<SurveyFit> survey() const override;
  std::optional<std::vector<LoopRecord>> loops() const override;
  std::vector<Eigen::Vector2f> trackedPixels() const override;
  roles::EstimatorReport report() const override;

 private:
  /// One of the rig, the first of which is [Estimator] camera_label.
  struct Camera {
    std::string label;
    bool first = false;
    bool refused = false;
    std::optional<CameraMount> mount;  ///< as its first image says; of others than the first
    int number = 0;                    ///< in the estimator; 0: the first, or not used
    long images = 0, undecodable = 0;
  };
  static constexpr std::size_t kMostHeld = 3000;  ///< where the first camera falls silent at once
  Camera* cameraOf(const std::string& label);
  void addImage(const mrpt::obs::CObservationImage& image, Camera* of);
  void addFirstImage(TimeNs t, const cv::Mat& gray);
  /// Cameras must be known before the first image is worked on.
  bool knowsOther(const mrpt::obs::CObservationImage& image, Camera* camera);
  void startRig();
  /// Now, or when the cameras are known.
  template <typename Action>
  void inTurn(Action&& action) {
    if (rig_started_ || !any_image_) {
      action();
      return;
    }
    held_.emplace_back(std::forward<Action>(action));
    if (held_.size() > kMostHeld) startRig();
  }
  void addTracks(const mrpt::obs::CObservationStereoImagesFeatures& tracks);
  bool knowsCamera(const mrpt::img::TCamera& camera, const mrpt::poses::CPose3D& T_B_C);
  void addImu(const mrpt::obs::CObservationIMU& imu);
  /// What the estimator has by now, of which `gray` (may be null) is the image of `t`.
  void pump(TimeNs t, const cv::Mat* gray);
  /// Counters of the cameras beside the first.
  void reportRig(const estimator::EstimatorCounters& counters, roles::EstimatorReport* r) const;
  void doubtRig(const estimator::EstimatorCounters& counters, roles::EstimatorReport* r) const;
  void warnOnce(const std::string& key, const std::string& text);

  VirSettings settings_;
  LogSink log_;
  std::unique_ptr<estimator::VisualInertialEstimator> estimator_;
  std::unique_ptr<estimator::LoopRun> loops_;  ///< where they are wanted
  roles::EstimatorOutput waiting_;             ///< taken from the estimator, not yet by the caller
  bool behind_ = false;                        ///< the estimator works in a thread of its own
  CameraCalibration calibration_;
  std::shared_ptr<const camera::CameraModel> camera_;  ///< for tracks
  TrackReader track_reader_;
  bool any_image_ = false;
  std::vector<Camera> cameras_;
  bool rig_started_ = false;
  std::vector<std::function<void()>> held_;  ///< until then, in order
  std::vector<std::string> warned_;
  std::vector<std::string> warnings_;
  imu::SaturationCounter imu_saturation_;
  long images_without_calibration_ = 0, imu_incomplete_ = 0;
};

}  // namespace vir
