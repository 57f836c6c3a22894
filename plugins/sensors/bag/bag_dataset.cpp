#include "bag_dataset.h"

#include <Eigen/Core>

#include "companion_ini.h"
//
#include <mrpt/config/CConfigFileBase.h>
#include <mrpt/img/CImage.h>
#include <mrpt/obs/CObservationBeaconRanges.h>
#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CObservationRobotPose.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "input_error.h"
#include "lever_arms.h"
#include "vir/rawlog/convert.h"
#include "vir/rawlog/labels.h"
#include "vir/rawlog/mrpt_camera.h"
#include "vir/rawlog/mrpt_pose.h"
#include "vir/rawlog/mrpt_time.h"
#include "vir/rawlog/range_differences.h"
#include "vir/roles/grabber_settings.h"

namespace vir {

IMPLEMENTS_GENERIC_SENSOR(Ros1Bag, vir)
IMPLEMENTS_GENERIC_SENSOR(Ros2Bag, vir)

namespace fs = std::filesystem;

namespace {

/// Readings per doProcess(): enough to be fast, few enough to keep the queue small.
constexpr int kBatch = 64;
/// Files of images that are written while reading goes on.
constexpr std::size_t kMostFiles = 3;

void writeFile(const std::string& path, const void* data, std::size_t size) {
  std::ofstream out(path, std::ios::binary);
  out.write(static_cast<const char*>(data), static_cast<std::streamsize>(size));
  out.close();
  if (!out) throw InputError("cannot write " + path + ": " + std::strerror(errno));
}

}  // namespace

bool Ros1Bag::canRead(const std::string& source) const {
  const bags::BagKind kind = bags::bagKindOf(source);
  return kind == bags::BagKind::ros1 || kind == bags::BagKind::ros1_folder;
}

bool Ros2Bag::canRead(const std::string& source) const {
  const bags::BagKind kind = bags::bagKindOf(source);
  return kind != bags::BagKind::none && kind != bags::BagKind::ros1 &&
         kind != bags::BagKind::ros1_folder;
}

BagSource::BagSource(std::string section) : section_(std::move(section)) { m_sensorLabel = "BAG"; }
BagSource::~BagSource() = default;

void BagSource::describe(OptionVisitor& v) { bag::describe(v, section_, options_); }

void BagSource::loadConfig_sensorSpecific(const mrpt::config::CConfigFileBase& config,
                                          const std::string& section) {
  roles::readGrabberSection(config, section, [this](OptionVisitor& v) { describe(v); });
  checkLeverArms(options_.lever_arm_m);
}

void BagSource::setPathForExternalImages(const std::string& directory) {
  m_path_for_external_images = directory;
}

std::string BagSource::listing(const std::string& source) const {
  const bag::Survey all = bag::survey(source, 0, {});
  std::string out = bag::listing(all);
  for (const std::string& d : all.damage) out += "note: " + d + "\n";
  return out;
}

void BagSource::initialize() {
  log_ = {};
  given_.clear();
  templates_.clear();
  finished_ = folder_ready_ = false;
  m_state = ssInitializing;
  embed_ = options_.images == "embed";
  if (!embed_ && m_path_for_external_images.empty()) {
    embed_ = true;
    log_.note("images = files: no folder for images was given; they are embedded");
  }
  bag::BagOptions options = options_;
  if (embed_) options.images = "embed";
  recording_ = std::make_unique<bag::BagRecording>(options, &log_);
  for (const bag::CameraSetup& c : recording_->cameras()) {
    auto obs = std::make_shared<mrpt::obs::CObservationImage>();
    if (c.has_intrinsics) obs->cameraParams = rawlog::toMrptCamera(c.intrinsics, c.topic);
    if (c.has_place) obs->cameraPose = rawlog::toMrptPose(c.T_B_C);
    templates_.push_back(obs);
  }
  waiting_.clear();
  files_waited_for_ = 0;
  m_state = ssWorking;
}

void BagSource::doProcess() {
  if (!recording_) throw InputError("BagSource: doProcess() before initialize()");
  for (int i = 0; i < kBatch && !finished_; ++i) {
    bag::Reading reading;
    if (!recording_->next(&reading)) {
      finish();
      return;
    }
    emit(&reading);
    if (std::holds_alternative<bag::ImageReading>(reading.what)) return;
  }
}

void BagSource::finish() {
  release(0);
  recording_->anchorPlaces().say(&log_);
  finished_ = true;
  long all = 0;
  for (const bag::Stream& s : recording_->streams()) {
    const long n = given_[s.label];
    all += n;
    if (n > 0 || s.role == bag::Role::accelerometer) continue;
    std::string why = log_.first("undecodable_" + s.label);
    if (why.empty() && s.role == bag::Role::camera) why = log_.first("image_wrong_size");
    log_.note(s.topic + ": gave nothing" + (why.empty() ? "" : "; first problem: " + why));
    const bool needed = s.label == rawlog::kCameraLabel || s.label == rawlog::kImuLabel ||
                        s.role == bag::Role::range;
    if (needed && !why.empty()) log_.count(roles::kUselessCounter);
  }
  if (all == 0) {
    throw InputError(options_.source + ": nothing in it could be used" +
                     (log_.messages().empty() ? "" : "; " + log_.messages().back()));
  }
}

void BagSource::emit(bag::Reading* reading) {
  const bag::Stream& s = recording_->streams()[static_cast<std::size_t>(reading->stream)];
  mrpt::obs::CObservation::Ptr obs;
  std::future<void> written;
  if (const auto* imu = std::get_if<ImuSample>(&reading->what)) {
    obs = rawlog::toObservation(*imu, s.label);
  } else if (const auto* range = std::get_if<Range>(&reading->what); range && range->reference) {
    obs = rawlog::differenceObservation(*range);
    ++given_[s.label];
    appendObservation(obs);
    return;
  } else if (range != nullptr) {
    obs = rawlog::toObservation(*range, reading->label.empty() ? s.label : reading->label);
  } else if (const auto* pose = std::get_if<StampedPose>(&reading->what)) {
    obs = rawlog::toObservation(*pose, s.label);
  } else if (const auto* told = std::get_if<bag::ToldPose>(&reading->what)) {
    const auto pose_obs = rawlog::toObservation(told->pose, s.label);
    for (int i = 0; i < 9; ++i) pose_obs->pose.cov(i / 3, i % 3) = told->covariance(i / 3, i % 3);
    const Vec3& p = s.p_B_U;
    pose_obs->sensorPose = mrpt::poses::CPose3D(p.x(), p.y(), p.z(), 0, 0, 0);
    obs = pose_obs;
  } else {
    obs = imageObservation(reading->t, &std::get<bag::ImageReading>(reading->what), s.label,
                           &written);
  }
  ++given_[obs->sensorLabel];
  files_waited_for_ += written.valid() ? 1 : 0;
  waiting_.push_back({obs, std::move(written)});
  release(kMostFiles);
}

/// Hands on what has its files, and as much more as it takes for no more than `most_waiting` files
/// to be written at a time.
void BagSource::release(std::size_t most_waiting) {
  while (!waiting_.empty()) {
    Waiting& first = waiting_.front();
    if (first.written.valid()) {
      const bool there =
          first.written.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
      if (!there && files_waited_for_ <= most_waiting) return;
      --files_waited_for_;
      first.written.get();  // throws what went wrong
    }
    appendObservation(first.observation);
    waiting_.pop_front();
  }
}

std::future<void> BagSource::writeLater(const std::string& path, bag::ImageReading* image) const {
  return std::async(std::launch::async, [path, image = std::move(*image)] {
    if (!image.file.empty()) {
      writeFile(path, image.file.data(), image.file.size());
      return;
    }
    std::vector<unsigned char> png;
    // With any level given OpenCV tries all filters of PNG: half as fast again for 8 % of size.
    cv::imencode(".png", image.pixels, png);
    writeFile(path, png.data(), png.size());
  });
}

mrpt::obs::CObservation::Ptr BagSource::imageObservation(TimeNs t, bag::ImageReading* image,
                                                         const std::string& label,
                                                         std::future<void>* written) {
  auto obs = std::make_shared<mrpt::obs::CObservationImage>(*templates_[image->camera]);
  obs->sensorLabel = label;
  obs->timestamp = rawlog::toMrptTime(t);
  if (embed_) {
    obs->image = mrpt::img::CImage(image->pixels, mrpt::img::SHALLOW_COPY);
    return obs;
  }
  if (!folder_ready_) {
    std::error_code ec;
    fs::create_directories(m_path_for_external_images, ec);
    if (ec) {
      throw InputError("cannot create the image folder " + m_path_for_external_images + ": " +
                       ec.message());
    }
    folder_ready_ = true;
  }
  const bool as_it_is = !image->file.empty();
  const std::string name = label + "_" + std::to_string(t) + (as_it_is ? image->extension : ".png");
  *written = writeLater(m_path_for_external_images + "/" + name, image);
  obs->image.setExternalStorage(name);
  return obs;
}

double BagSource::progress() const {
  if (finished_) return 1;
  return recording_ ? recording_->progress() : 0;
}

std::vector<std::pair<std::string, long>> BagSource::counters() const {
  std::vector<std::pair<std::string, long>> out;
  for (const auto& [label, n] : given_) {
    if (n > 0) out.emplace_back("readings_" + label, n);
  }
  const auto problems = log_.counters();
  out.insert(out.end(), problems.begin(), problems.end());
  return out;
}

std::vector<SurveyedAnchor> BagSource::surveyedAnchors() const {
  if (!recording_) return {};
  return recording_->anchorPlaces().standing();
}

std::string BagSource::companionIni() const {
  if (!recording_) return {};
  return recording_->extras().ini + recording_->anchors().remarks();
}

}  // namespace vir
