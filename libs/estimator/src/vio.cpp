#include "vir/estimator/vio.h"

#include <opencv2/core/mat.hpp>
#include <stdexcept>
#include <utility>

namespace vir::estimator {
namespace {

EstimatorConfig withCalibration(EstimatorConfig config, const Calibration& calibration) {
  const auto list = [](const Vec3& v) { return std::vector<double>{v.x(), v.y(), v.z()}; };
  config.camera_time_offset_s = calibration.time_offset_s;
  if (calibration.readout_s != 0) config.window.readout_s = calibration.readout_s;
  if (!calibration.gyro_gain.isZero()) config.gyro_gain = list(calibration.gyro_gain);
  if (!calibration.gyro_axes_rad.isZero()) config.gyro_axes_rad = list(calibration.gyro_axes_rad);
  if (!calibration.acc_gain.isZero()) config.acc_gain = list(calibration.acc_gain);
  return config;
}

}  // namespace

EstimatorConfig configFrom(const Settings& settings) {
  EstimatorConfig config;
  SettingsReader reader(settings);
  describe(reader, config);
  reader.finish();
  return config;
}

Vio::Vio(const Calibration& calibration, const EstimatorConfig& config, LogSink log)
    : given_(calibration),
      estimator_(std::make_unique<VisualInertialEstimator>(withCalibration(config, calibration),
                                                           std::move(log))) {
  estimator_->setCamera(calibration.camera, calibration.T_B_C);
  for (const CameraMount& mount : calibration.further) estimator_->addCamera(mount);
}

int Vio::addCamera(const CameraMount& mount) {
  const int number = estimator_->addCamera(mount);
  given_.further.push_back(mount);
  return number;
}

Vio::~Vio() = default;
Vio::Vio(Vio&&) noexcept = default;
Vio& Vio::operator=(Vio&&) noexcept = default;

void Vio::onState(std::function<void(const StateEstimate&)> listener) {
  on_state_ = std::move(listener);
}

void Vio::onRange(std::function<void(const RangeRecord&)> listener) {
  on_range_ = std::move(listener);
}

void Vio::add(const ImuSample& sample) {
  estimator_->addImu(sample);
  tell();
}

void Vio::add(const Image& image) {
  if (image.pixels == nullptr) throw std::invalid_argument("vir::Vio: an image without pixels");
  if (image.camera < 0 || image.camera > static_cast<int>(given_.further.size())) {
    throw std::invalid_argument("vir::Vio: an image of camera " + std::to_string(image.camera) +
                                ", which was not added");
  }
  const CameraCalibration& camera =
      image.camera == 0 ? given_.camera
                        : given_.further[static_cast<std::size_t>(image.camera) - 1].camera;
  if (image.width != camera.width || image.height != camera.height) {
    throw std::invalid_argument("vir::Vio: an image of " + std::to_string(image.width) + " x " +
                                std::to_string(image.height) + " pixels, the calibration is for " +
                                std::to_string(camera.width) + " x " +
                                std::to_string(camera.height));
  }
  const std::size_t row = static_cast<std::size_t>(image.width);
  // OpenCV has no view of constant pixels; nothing writes to them.
  const cv::Mat gray(image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.pixels),
                     image.stride == 0 ? row : image.stride);
  estimator_->addImage(image.t, gray, image.camera);
  tell();
}

void Vio::add(const Range& range) { estimator_->addRange(range); }

void Vio::finish() {
  estimator_->finish();
  tell();
}

void Vio::add(const AnchorRange& range) { estimator_->addAnchorRange(range); }

void Vio::tell() {
  estimator_->takeSettled();  // keyframes() shows enough of them
  for (const StateEstimate& state : estimator_->take()) {
    if (on_state_) on_state_(state);
  }
  for (const RangeRecord& range : estimator_->takeRanges()) {
    if (on_range_) on_range_(range);
  }
}

std::vector<Anchor> Vio::anchors() const { return estimator_->anchors(); }
std::optional<SurveyFit> Vio::survey() const { return estimator_->survey(); }

std::vector<StampedPose> Vio::keyframes() const {
  std::vector<StampedPose> out;
  for (const State& s : estimator_->keyframes()) out.push_back({s.t, s.T_W_B});
  return out;
}

std::vector<Landmark> Vio::landmarks() const { return estimator_->landmarks(); }

Calibration Vio::calibration() const { return estimator_->calibration(); }

std::vector<std::string> Vio::warnings() const { return estimator_->warnings(); }

}  // namespace vir::estimator
