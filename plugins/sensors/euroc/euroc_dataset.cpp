#include <Eigen/Core>
//
#include <mrpt/config/CConfigFileBase.h>
#include <mrpt/img/CImage.h>
#include <mrpt/obs/CObservationBeaconRanges.h>
#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CObservationRobotPose.h>

#include "companion_ini.h"
#include "euroc_dataset.h"
#include "input_error.h"
#include "lever_arms.h"
#include "table_folder.h"
#include "vir/rawlog/anchor_ranges.h"
#include "vir/rawlog/convert.h"
#include "vir/rawlog/labels.h"
#include "vir/rawlog/mrpt_camera.h"
#include "vir/rawlog/mrpt_pose.h"
#include "vir/rawlog/mrpt_time.h"
#include "vir/rawlog/range_differences.h"
#include "vir/roles/grabber_settings.h"

namespace vir {

IMPLEMENTS_GENERIC_SENSOR(EurocDataset, vir)
IMPLEMENTS_GENERIC_SENSOR(CsvDataset, vir)

namespace {

using euroc::Event;

/// Events per doProcess(): enough to be fast, few enough to keep the queue small.
constexpr int kBatch = 64;

euroc::ImageMode modeOf(const std::string& name) {
  if (name == "copy") return euroc::ImageMode::copy;
  return name == "embed" ? euroc::ImageMode::embed : euroc::ImageMode::link;
}

}  // namespace

FolderSource::FolderSource(const std::string& section) {
  options_.section = section;
  m_sensorLabel = "FOLDER";
}
FolderSource::~FolderSource() = default;

std::unique_ptr<euroc::Recording> EurocDataset::openRecording(const euroc::EurocOptions& options,
                                                              ProblemLog* log) const {
  return std::make_unique<euroc::Recording>(options, log);
}

bool CsvDataset::canRead(const std::string& source) const { return euroc::isTableFolder(source); }

std::string CsvDataset::listing(const std::string& source) const {
  return euroc::listTables(source);
}

std::unique_ptr<euroc::Recording> CsvDataset::openRecording(const euroc::EurocOptions& options,
                                                            ProblemLog* log) const {
  euroc::validate(options);
  return std::make_unique<euroc::Recording>(euroc::findTables(options), options, log);
}

void FolderSource::describe(OptionVisitor& v) { euroc::describe(v, options_); }

void FolderSource::loadConfig_sensorSpecific(const mrpt::config::CConfigFileBase& config,
                                             const std::string& section) {
  roles::readGrabberSection(config, section, [this](OptionVisitor& v) { describe(v); });
  checkLeverArms(options_.lever_arm_m);
}

void FolderSource::setPathForExternalImages(const std::string& directory) {
  m_path_for_external_images = directory;
}

void FolderSource::initialize() {
  log_ = {};
  given_.clear();
  cameras_.clear();
  finished_ = false;
  m_state = ssInitializing;
  recording_ = openRecording(options_, &log_);
  euroc::ImageMode mode = modeOf(options_.images);
  if (!recording_->cameras().empty() && mode != euroc::ImageMode::embed &&
      m_path_for_external_images.empty()) {
    mode = euroc::ImageMode::embed;
    log_.note("images = " + options_.images +
              ": no folder for images was given; they are embedded");
  }
  for (const euroc::CameraStream& stream : recording_->cameras()) openCamera(stream, mode);
  m_state = ssWorking;
}

void FolderSource::openCamera(const euroc::CameraStream& stream, euroc::ImageMode mode) {
  const CameraCalibration& c = stream.calibration.camera;
  Camera camera;
  camera.dir = stream.files.dir;
  camera.label = stream.label;
  camera.store = std::make_unique<euroc::ImageStore>(mode, m_path_for_external_images, stream.label,
                                                     stream.file_width, stream.file_height, &log_);
  camera.store->setTarget(c.width, c.height);
  camera.store->setStretch(stream.stretch.black, stream.stretch.white, stream.stretch.eight_bit);
  auto obs = std::make_shared<mrpt::obs::CObservationImage>();
  obs->sensorLabel = stream.label;
  obs->cameraParams = rawlog::toMrptCamera(c, stream.files.name);
  obs->cameraPose = rawlog::toMrptPose(stream.calibration.T_B_C);
  camera.image_template = obs;
  cameras_.push_back(std::move(camera));
}

void FolderSource::doProcess() {
  if (!recording_) throw InputError("FolderSource: doProcess() before initialize()");
  for (int i = 0; i < kBatch && !finished_; ++i) {
    Event event;
    if (!recording_->next(&event)) {
      finish();
      return;
    }
    emit(event);
    if (std::holds_alternative<euroc::ImageRow>(event.what)) return;
  }
}

void FolderSource::finish() {
  finished_ = true;
  if (!cameras_.empty() && given_["images"] == 0) {
    std::string why;
    for (const char* kind : {"image_missing", "image_undecodable", "image_wrong_size"}) {
      if (why.empty()) why = log_.first(kind);
    }
    throw InputError("no image of " + cameras_[0].dir + " could be used" +
                     (why.empty() ? "" : "; first problem: " + why));
  }
  // Of the robot's ranges, and of those between anchors.
  for (const auto& [given, problems] :
       {std::pair{"ranges", "range_"}, {"anchor_ranges", "anchor_range_"}}) {
    long ranges = 0, lost = 0;
    for (const auto& [name, n] : given_) ranges += name.rfind(given, 0) == 0 ? n : 0;
    for (const auto& [name, n] : log_.counters()) lost += name.rfind(problems, 0) == 0 ? n : 0;
    if (ranges == 0 && lost > 0) log_.count(roles::kUselessCounter);
  }
}

void FolderSource::emit(const Event& event) {
  mrpt::obs::CObservation::Ptr obs;
  std::string counter;
  if (const auto* imu = std::get_if<ImuSample>(&event.what)) {
    obs = rawlog::toObservation(*imu, rawlog::kImuLabel);
    counter = "imu_samples";
  } else if (const auto* range = std::get_if<euroc::RangeRow>(&event.what)) {
    const auto& streams = recording_->rangeStreams();
    if (range->from) {
      obs = rawlog::toObservation(AnchorRange{event.t, static_cast<std::uint32_t>(*range->from),
                                              static_cast<std::uint32_t>(range->anchor),
                                              range->range_m, range->sigma_m});
      ++given_["anchor_ranges"];
      appendObservation(obs);
      return;
    }
    const bool drawn = streams.empty();
    const std::string label = drawn ? rawlog::kRangeLabel : streams[event.stream].label;
    Range measured{event.t, static_cast<std::uint32_t>(range->anchor), range->range_m,
                   drawn ? options_.range_sigma_m : range->sigma_m,
                   range->place.value_or(recording_->antennaInBody())};
    if (range->reference) {
      measured.reference = static_cast<std::uint32_t>(*range->reference);
      ++given_["ranges_differences"];
      appendObservation(rawlog::differenceObservation(measured));
      return;
    }
    obs = rawlog::toObservation(measured, label, rawlog::kUnknownRadio);
    counter = label == rawlog::kRangeLabel ? "ranges" : "ranges_" + label;
  } else if (const auto* pose = std::get_if<euroc::PoseRow>(&event.what)) {
    obs = rawlog::toObservation(StampedPose{event.t, pose->T_W_B}, rawlog::kGroundTruthLabel);
    counter = "ground_truth_poses";
  } else {
    emitImage(event, std::get<euroc::ImageRow>(event.what));
    return;
  }
  ++given_[counter];
  appendObservation(obs);
}

void FolderSource::emitImage(const Event& event, const euroc::ImageRow& row) {
  euroc::StoredImage stored;
  Camera& camera = cameras_[event.stream];
  const bool stored_well =
      row.pixels.empty() ? camera.store->store(event.t, euroc::imageFile(camera.dir, row.file),
                                               event.where, &stored)
                         : camera.store->store(event.t, row.pixels, event.where, &stored);
  if (!stored_well) return;
  auto obs = std::make_shared<mrpt::obs::CObservationImage>(*camera.image_template);
  obs->timestamp = rawlog::toMrptTime(event.t);
  if (stored.external_name.empty()) {
    obs->image = mrpt::img::CImage(stored.pixels, mrpt::img::SHALLOW_COPY);
  } else {
    obs->image.setExternalStorage(stored.external_name);
  }
  ++given_[event.stream == 0 ? "images" : "images_" + camera.label];
  appendObservation(obs);
}

double FolderSource::progress() const {
  if (finished_) return 1;
  return recording_ ? recording_->progress() : 0;
}

std::vector<std::pair<std::string, long>> FolderSource::counters() const {
  std::vector<std::pair<std::string, long>> out(given_.begin(), given_.end());
  const auto problems = log_.counters();
  out.insert(out.end(), problems.begin(), problems.end());
  return out;
}

std::vector<std::string> FolderSource::warnings() const { return log_.messages(); }

std::string FolderSource::companionIni() const {
  if (!recording_) return {};
  std::string out;
  if (const euroc::ImuYaml& imu = recording_->imu(); imu.has_noise) {
    const std::string from = options_.calibration.empty() && !recording_->folder().imu_yaml.empty()
                                 ? recording_->folder().imu_yaml
                                 : "the calibration";
    out = "// Noise of the IMU, taken from " + from + "\n" + imuSection(imu);
  }
  if (!recording_->cameras().empty()) {
    out += cameraSection(recording_->cameras()[0].time_offset_s, recording_->otherTimeOffsets());
  }
  return out + recording_->anchorNames().remarks();
}

std::vector<roles::TrueAnchor> FolderSource::trueAnchors() const {
  std::vector<roles::TrueAnchor> anchors;
  if (!recording_) return anchors;
  for (const euroc::AnchorRow& a : recording_->trueAnchors()) {
    anchors.push_back({static_cast<std::uint32_t>(a.id), a.p_W});
  }
  return anchors;
}

std::vector<SurveyedAnchor> FolderSource::surveyedAnchors() const {
  if (!recording_) return {};
  return recording_->anchorPlaces().standing();
}

}  // namespace vir
