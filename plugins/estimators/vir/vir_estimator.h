#pragma once
/// Estimator plugin `vir`: MRPT observations to the visual-inertial estimator and back.
#include "tracks_of.h"
#include "vir/estimator/visual_inertial_estimator.h"
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

class VirEstimator final : public roles::Estimator {
 public:
  void describe(OptionVisitor& v) override;
  bool workBehind(std::function<void()> on_estimates) override;
  void start(const LogSink& log) override;
  bool reads(const mrpt::obs::CObservation& observation) const override;
  void add(const mrpt::obs::CObservation& observation) override;
  void finish() override;
  std::vector<roles::StateEstimate> take() override;
  std::vector<roles::LandmarkEstimate> landmarks() const override;
  std::vector<roles::KeyframeEstimate> keyframes() const override;
  std::vector<roles::AnchorEstimate> anchors() const override;
  std::vector<roles::RangeRecord> takeRanges() override;
  std::vector<Eigen::Vector2f> trackedPixels() const override;
  roles::EstimatorReport report() const override;

 private:
  void addImage(const mrpt::obs::CObservationImage& image);
  void addTracks(const mrpt::obs::CObservationStereoImagesFeatures& tracks);
  bool knowsCamera(const mrpt::img::TCamera& camera, const mrpt::poses::CPose3D& T_B_C);
  void addImu(const mrpt::obs::CObservationIMU& imu);
  void warnOnce(const std::string& key, const std::string& text);

  estimator::EstimatorConfig config_;
  std::string camera_label_ = "CAM0";
  std::string tracks_label_ = "TRACKS0";
  std::string imu_label_ = "IMU0";
  std::string range_label_ = "UWB0";
  LogSink log_;
  std::function<void()> on_estimates_;
  std::unique_ptr<estimator::VisualInertialEstimator> estimator_;
  camera::CameraCalibration calibration_;
  std::shared_ptr<const camera::CameraModel> camera_;  ///< for tracks
  TrackReader track_reader_;
  bool any_image_ = false;
  std::vector<std::string> warned_;
  std::vector<std::string> warnings_;
  long images_undecodable_ = 0, images_without_calibration_ = 0, imu_incomplete_ = 0;
};

}  // namespace vir
