#include "vir/estimator/vio.h"

#include <opencv2/core/mat.hpp>
#include <stdexcept>
#include <utility>

namespace vir::estimator {
namespace {

EstimatorConfig withCalibration(const VioConfig& given, const Calibration& calibration) {
  EstimatorConfig config = given;
  config.tell_sights = given.loops.use;
  const auto list = [](const Vec3& v) { return std::vector<double>{v.x(), v.y(), v.z()}; };
  config.camera_time_offset_s = calibration.time_offset_s;
  if (calibration.readout_s != 0) config.window.readout_s = calibration.readout_s;
  if (!calibration.gyro_gain.isZero()) config.gyro_gain = list(calibration.gyro_gain);
  if (!calibration.gyro_axes_rad.isZero()) config.gyro_axes_rad = list(calibration.gyro_axes_rad);
  if (!calibration.acc_gain.isZero()) config.acc_gain = list(calibration.acc_gain);
  return config;
}

}  // namespace

VioConfig configFrom(const Settings& settings) {
  VioConfig config;
  SettingsReader reader(settings);
  reader.section("Estimator", "");
  describeUse(reader, config.loops);
  describe(reader, static_cast<EstimatorConfig&>(config));
  describe(reader, config.loops);
  reader.finish();
  return config;
}

Vio::Vio(const Calibration& calibration, const VioConfig& config, LogSink log)
    : given_(calibration),
      estimator_(
          std::make_unique<VisualInertialEstimator>(withCalibration(config, calibration), log)) {
  estimator_->setCamera(calibration.camera, calibration.T_B_C);
  if (config.loops.use) {
    loops_ = std::make_unique<LoopRun>(config.loops, std::move(log));
    loops_->setCamera(estimator_->givenCalibration());
  }
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

void Vio::onRevision(std::function<void(const Revision&)> listener) {
  on_revision_ = std::move(listener);
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
  // Places are those of the first camera.
  tell(image.t, image.camera == 0 ? &gray : nullptr);
}

void Vio::add(const Range& range) { estimator_->addRange(range); }

void Vio::finish() {
  estimator_->finish();
  tell();
  if (!loops_) return;
  loops_->finish(*estimator_);
  tell();
}

void Vio::add(const AnchorRange& range) { estimator_->addAnchorRange(range); }

void Vio::tell(TimeNs t, const cv::Mat* gray) {
  LoopedOutput out;
  if (loops_) {
    out = loops_->take(estimator_.get(), t, gray);
  } else {
    estimator_->takeSettled();  // keyframes() shows enough of them
    out.states = estimator_->take();
    out.ranges = estimator_->takeRanges();
  }
  for (const StateEstimate& state : out.states) {
    if (on_state_) on_state_(state);
  }
  for (const Revision& revision : out.revisions) {
    if (on_revision_) on_revision_(revision);
  }
  for (const RangeRecord& range : out.ranges) {
    if (on_range_) on_range_(range);
  }
}

LoopRun& Vio::withLoops() const {
  if (!loops_) throw std::logic_error("vir::Vio: there are no maps without loops");
  return *loops_;
}

void Vio::loadMap(const std::string& file) { withLoops().loadMap(file); }
void Vio::saveMap(const std::string& file) const { withLoops().saveMap(*estimator_, file); }
bool Vio::found() const { return !loops_ || loops_->found(); }
LevelTransform Vio::correction() const { return loops_ ? loops_->correction() : LevelTransform(); }
std::vector<LoopRecord> Vio::loops() const {
  return loops_ ? loops_->records() : std::vector<LoopRecord>();
}

std::vector<Anchor> Vio::anchors() const {
  return loops_ ? loops_->anchors(estimator_->anchors()) : estimator_->anchors();
}
std::optional<SurveyFit> Vio::survey() const {
  return loops_ ? loops_->survey(estimator_->survey()) : estimator_->survey();
}

std::vector<StampedPose> Vio::keyframes() const {
  if (loops_) return loops_->keyframes(*estimator_);
  std::vector<StampedPose> out;
  for (const State& s : estimator_->keyframes()) out.push_back({s.t, s.T_W_B});
  return out;
}

std::vector<Landmark> Vio::landmarks() const {
  return loops_ ? loops_->landmarks(*estimator_) : estimator_->landmarks();
}

Calibration Vio::calibration() const { return estimator_->calibration(); }

std::vector<std::string> Vio::warnings() const {
  std::vector<std::string> out = loops_ ? loops_->warnings() : std::vector<std::string>();
  for (const std::string& w : estimator_->warnings()) out.push_back(w);
  return out;
}

}  // namespace vir::estimator
