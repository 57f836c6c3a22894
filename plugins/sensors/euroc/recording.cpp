#include "recording.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>

#include "image_list.h"
#include "input_error.h"
#include "lever_arms.h"
#include "range_streams.h"
#include "stream_setup.h"
#include "vir/core/text_file.h"
#include "vir/formats/calibration_file.h"
#include "vir/rawlog/labels.h"

namespace vir::euroc {
namespace fs = std::filesystem;
namespace {

/// Longer holes are worth a line in the report.
constexpr TimeNs kGap = 500'000'000;
constexpr TimeNs kEnd = std::numeric_limits<TimeNs>::max();

bool isIdentity(const Pose& T) {
  return T.p.norm() < 1e-9 && T.q.angularDistance(Quat::Identity()) < 1e-9;
}

template <typename Row>
void requireRows(const RowStream<Row>& c, const ProblemLog& log) {
  if (c.peek()) return;
  const std::string no_text = whyNoText(c.path());
  if (!no_text.empty()) throw InputError(c.path() + " " + no_text);
  std::string why;
  for (const char* kind : {"malformed", "before_zero", "not_finite", "implausible", "cut_line",
                           "too_late", "repeated"}) {
    if (why.empty()) why = log.first(c.name() + "_" + kind);
  }
  throw InputError(c.path() + ": holds no usable row" +
                   (why.empty() ? "" : "; first problem: " + why));
}

template <typename Cursor>
void skipUntil(Cursor* c, TimeNs t) {
  while (c && c->peek() && c->peek()->t < t) c->pop();
}

}  // namespace

Recording::Recording(const EurocOptions& o, ProblemLog* log)
    : Recording((validate(o), findFolder(o.source, o.camera)), o, log) {}

Recording::Recording(Folder folder, const EurocOptions& o, ProblemLog* log)
    : log_(log), folder_(std::move(folder)), section_(o.section), units_(unitsOf(o)) {
  validate(o);
  for (const std::string& note : folder_.notes) log_->note(note);
  for (const std::string& list : folder_.without_images) {
    log_->note(list + ": taken for a list of images, but they are not there; put them beside it");
    log_->count("image_missing");
  }
  if (!folder_.unread.empty()) {
    log_->count("table_not_read", static_cast<long>(folder_.unread.size()));
  }
  openCalibration(o);
  openStreams(o);
}

std::string Recording::calibrationFile(const EurocOptions& o) const {
  return o.calibration.empty() ? folder_.calibration : o.calibration;
}

void Recording::openCalibration(const EurocOptions& o) {
  if (!folder_.imu_yaml.empty()) {
    imu_calibration_ = readImuYaml(folder_.imu_yaml, log_);
  } else if (section_ != "csv") {
    log_->note(fs::path(folder_.imu_file).parent_path().string() +
               "/sensor.yaml: missing; the IMU is taken as the body frame, noise densities as "
               "unknown");
  }
  const Pose& T_B_I = imu_calibration_.T_B_I;
  if (!isIdentity(T_B_I)) {
    log_->note(folder_.imu_yaml +
               ": T_BS is not the identity; body is the IMU here, so camera, antenna and ground "
               "truth were moved to the IMU's frame");
  }
  for (const CameraFiles& files : folder_.cameras) {
    const bool further = !cameras_.empty();
    if (further && !o.other_cameras) {
      log_->note(files.dir + ": not read (other_cameras = false)");
      continue;
    }
    // A second one without calibration is of no use.
    if (further && section_ != "csv" && files.yaml.empty() &&
        !readGivenCalibration(calibrationFile(o), files.name, false).isWhole()) {
      log_->note(files.dir + ": not read, it has no sensor.yaml" +
                 (calibrationFile(o).empty() ? "" : " and is not whole in " + calibrationFile(o)));
      continue;
    }
    CameraStream camera;
    camera.files = files;
    camera.label = cameras_.empty() ? std::string(rawlog::kCameraLabel)
                                    : labelOf(files.name, rawlog::kCameraLabel);
    // The estimator's camera is CAM0, whichever it is.
    if (!cameras_.empty() && camera.label == rawlog::kCameraLabel) {
      camera.label = labelOf(cameras_[0].files.name, rawlog::kCameraLabel);
    }
    openCamera(o, &camera, cameras_.empty());
    cameras_.push_back(std::move(camera));
  }
  antenna_ = leverArm(o.lever_arm_m, 0);
  T_S_B_truth_ = T_B_I;
  if (!folder_.truth_file.empty() && !folder_.truth_yaml.empty()) {
    T_S_B_truth_ = readSensorPose(folder_.truth_yaml).inverse() * T_B_I;
  }
}

std::vector<double> Recording::otherTimeOffsets() const {
  std::vector<std::optional<double>> offsets;
  for (const CameraStream& c : cameras_) offsets.push_back(c.time_offset_s);
  return formats::otherTimeOffsets(offsets);
}

void Recording::openCamera(const EurocOptions& o, CameraStream* camera, bool first) {
  const std::string& yaml = camera->files.yaml;
  const std::string file = calibrationFile(o);
  const GivenCalibration given = readGivenCalibration(file, camera->files.name, first);
  for (const std::string& note : given.notes) log_->note(file + ": " + note);
  const bool table_only = yaml.empty() && section_ == "csv";
  if (!given.camera && table_only) {
    throw InputError((file.empty() ? folder_.root + ": holds no calibration of the camera"
                                   : file + ": says nothing of the camera's intrinsics") +
                     "; give --calibration FILE with intrinsics, distortion and the camera's pose "
                     "on the IMU, or leave the images out: --topic camera=none");
  }
  CameraYaml& calibration = camera->calibration;
  calibration.has_pose = false;
  if (!table_only && !(given.camera && given.T_B_C)) {
    calibration = readCameraYaml(yaml.empty() ? camera->files.dir + "/sensor.yaml" : yaml);
    if (calibration.has_pose) {
      calibration.T_B_C = imu_calibration_.T_B_I.inverse() * calibration.T_B_C;
    }
  }
  std::string what;
  const auto take = [&](const char* part) {
    what += (what.empty() ? "" : ", ") + std::string(part);
  };
  if (given.camera) calibration.camera = *given.camera, take("the camera's intrinsics");
  if (given.T_B_C) {
    calibration.T_B_C = *given.T_B_C, take("its pose on the IMU");
    calibration.has_pose = true;
  }
  if (given.time_offset_s) {
    camera->time_offset_s = given.time_offset_s, take("its time offset");
  }
  if (first && given.imu) {
    const Pose T_B_I = imu_calibration_.T_B_I;
    imu_calibration_ = *given.imu;
    imu_calibration_.T_B_I = T_B_I;
    take("the IMU's noise");
  }
  if (!what.empty()) log_->note("from " + file + ": " + what);
  if (!calibration.has_pose) {
    log_->note(camera->files.name +
               ": its pose on the IMU is not given (T_BS, 4x4, of its sensor.yaml, or T_cam_imu of "
               "Kalibr's by --calibration): a run finds it on the way");
  }
}

void Recording::findTrueAnchors(const EurocOptions& o) {
  if (o.simulate_ranges) {
    const std::vector<double>& p = o.anchor_m;
    for (std::size_t i = 0; 3 * i + 2 < p.size(); ++i) {
      const int id = o.anchor_id.empty() ? static_cast<int>(i) : static_cast<int>(o.anchor_id[i]);
      true_anchors_.push_back({id, Vec3(p[3 * i], p[3 * i + 1], p[3 * i + 2])});
    }
    return;
  }
  if (!o.read_ranges) return;
  for (const RangeFiles& r : folder_.ranges) {
    if (r.anchors.empty() || !true_anchors_.empty()) continue;
    true_anchors_ = readAnchorTable(r.anchors, &anchor_names_, log_);
  }
}

void Recording::noteAnchorNames() {
  for (const auto& [name, number] : anchor_names_.mapped()) {
    log_->note("anchor " + tables::shownName(name) + " is " + std::to_string(number) +
               " in the rawlog");
  }
}

void Recording::openRangeStreams(const EurocOptions& o) {
  const bool has_truth = !folder_.truth_file.empty();
  if (o.simulate_ranges) {
    if (!has_truth) {
      throw InputError("[" + section_ + "] simulate_ranges = true needs a ground truth in " +
                       folder_.root);
    }
    if (!folder_.ranges.empty())
      log_->note(fs::path(folder_.ranges[0].file).parent_path().string() +
                 ": not read, ranges are drawn instead");
    drawn_ = std::make_unique<RangeSimulator>(o, openGroundTruth(folder_.truth_file, &silent_),
                                              T_S_B_truth_, log_);
    return;
  }
  if (!o.read_ranges) return;
  ranges_ =
      openRangeFiles(folder_.ranges, o, imu_calibration_.T_B_I, &anchor_names_, log_, &silent_);
}

void Recording::openStreams(const EurocOptions& o) {
  findTrueAnchors(o);
  TimeNs origin = 0;
  if (!folder_.imu_file.empty()) {
    imu_ = folder_.accelerometer_file.empty()
               ? openImu(folder_.imu_file, units_, log_)
               : openSplitImu(folder_.imu_file, folder_.accelerometer_file, units_, log_);
    requireRows(*imu_, *log_);
    origin = imu_->peek()->t;
  }
  if (!imu_ && section_ == "csv") {
    log_->note(folder_.root +
               ": no IMU: no table has columns of gyro and accelerometer that could "
               "be told as such; name it: --topic imu=FILE");
  }
  if (cameras_.empty() && section_ == "csv") {
    log_->note(folder_.root +
               ": no images: there is no list or folder of them that could be told as such, nor a "
               "video; name it: --topic camera=FILE");
  }
  for (CameraStream& camera : cameras_) {
    const auto imu_start = imu_ ? std::optional<TimeNs>(imu_->peek()->t) : std::nullopt;
    camera.rows = openCameraImages(o, camera.files, imu_start, log_);
    requireRows(*camera.rows, *log_);
    fitToImages(o, &camera, log_);
  }
  if (!cameras_.empty()) origin = cameras_[0].rows->peek()->t;
  const bool has_truth = !folder_.truth_file.empty();
  if (!has_truth) {
    log_->note(folder_.root + (section_ == "csv" ? ": no ground truth"
                                                 : ": no ground truth (state_groundtruth_estimate0 "
                                                   "or mocap0)"));
  }
  if (has_truth && o.read_gt) truth_ = openGroundTruth(folder_.truth_file, log_);
  openRangeStreams(o);
  if (origin == 0) origin = nextTime();
  setWindow(o, origin);
}

void Recording::setWindow(const EurocOptions& o, TimeNs origin) {
  from_ = 0;
  until_ = kEnd;
  const double longest = toSeconds(kEnd - origin) / 2;
  if (o.start_s > 0) from_ = origin + fromSeconds(std::min(o.start_s, longest));
  if (o.max_duration_s > 0) {
    until_ = std::max(from_, origin) + fromSeconds(std::min(o.max_duration_s, longest));
  }
  skipTo(from_);
  const bool nothing = !cameras_.empty() ? cameras_[0].rows->peek() == nullptr
                       : imu_            ? imu_->peek() == nullptr
                                         : nextTime() == kEnd;
  if (nothing) {
    throw InputError("[" + section_ + "] start_s = " + std::to_string(o.start_s) +
                     " lies behind the end of the recording");
  }
  now_ = from_;
}

void Recording::skipTo(TimeNs t) {
  skipUntil(imu_.get(), t);
  for (CameraStream& camera : cameras_) skipUntil(camera.rows.get(), t);
  for (RangeStream& s : ranges_) {
    while (s.rows->peek() != nullptr && s.rows->peek()->t < t) {
      s.rows->pop();
      skipOtherAntennas(&s, log_);
    }
  }
  skipUntil(truth_.get(), t);
  skipUntil(drawn_.get(), t);
}

void Recording::watchGap(TimeNs t, TimeNs* last, const char* counter, const std::string& file) {
  if (*last > 0 && t - *last > kGap) {
    char text[64];
    std::snprintf(text, sizeof text, "nothing for %.3f s before %lld", toSeconds(t - *last),
                  static_cast<long long>(t));
    log_->add(counter, file, text);
  }
  *last = t;
}

TimeNs Recording::nextTime() const {
  TimeNs t = imu_ && imu_->peek() ? imu_->peek()->t : kEnd;
  for (const RangeStream& s : ranges_) {
    if (s.rows->peek()) t = std::min(t, s.rows->peek()->t);
  }
  if (drawn_ && drawn_->peek()) t = std::min(t, drawn_->peek()->t);
  if (truth_ && truth_->peek()) t = std::min(t, truth_->peek()->t);
  for (const CameraStream& camera : cameras_) {
    if (camera.rows->peek()) t = std::min(t, camera.rows->peek()->t);
  }
  return t;
}

bool Recording::takeRange(Event* event) {
  for (std::size_t i = 0; i < ranges_.size(); ++i) {
    RowStream<RangeRow>& rows = *ranges_[i].rows;
    if (rows.peek() == nullptr || rows.peek()->t != event->t) continue;
    RangeRow row = *rows.peek();
    if (ranges_[i].by_settings || !row.place) row.place = ranges_[i].antenna;
    // Of ranges between anchors the run's own setting is the noise.
    if (!(row.sigma_m > 0)) row.sigma_m = ranges_[i].sigma_m;
    if (row.anchor_place) {
      anchor_places_.add(static_cast<std::uint32_t>(row.anchor), *row.anchor_place);
    }
    event->what = std::move(row);
    event->stream = i;
    rows.pop();
    skipOtherAntennas(&ranges_[i], log_);
    return true;
  }
  if (!drawn_ || drawn_->peek() == nullptr || drawn_->peek()->t != event->t) return false;
  const SimulatedRange& r = *drawn_->peek();
  event->what = RangeRow{r.t, r.anchor, r.range_m, {}, {}, 0, {}};
  if (!r.line_of_sight) log_->count("range_drawn_without_line_of_sight");
  drawn_->pop();
  return true;
}

void Recording::takePose(Event* event) {
  PoseRow pose = *truth_->peek();
  if (pose.has_attitude) {
    pose.T_W_B = pose.T_W_B * T_S_B_truth_;
  } else if (!isIdentity(T_S_B_truth_) && !said_truth_lever_) {
    said_truth_lever_ = true;
    log_->note(truth_->path() +
               ": positions without attitude cannot be moved to the IMU: they "
               "are those of the tracked point, " +
               std::to_string(T_S_B_truth_.p.norm()) + " m from it");
  }
  event->what = pose;
  truth_->pop();
}

void Recording::takeImage(Event* event) {
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    RowStream<ImageRow>& rows = *cameras_[i].rows;
    if (rows.peek() == nullptr || rows.peek()->t != event->t) continue;
    event->what = *rows.peek();
    event->where = rows.where();
    event->stream = i;
    rows.pop();
    if (i == 0) watchGap(event->t, &last_image_, "image_gap", rows.path());
    return;
  }
}

bool Recording::next(Event* event) {
  const TimeNs t = nextTime();
  if (t == kEnd || t > until_) {
    noteAnchorNames();
    anchor_places_.say(log_);
    return false;
  }
  event->t = now_ = t;
  event->stream = 0;
  event->where.clear();
  if (imu_ && imu_->peek() && imu_->peek()->t == t) {
    event->what = *imu_->peek();
    imu_->pop();
    watchGap(t, &last_imu_, "imu_gap", imu_->path());
  } else if (takeRange(event)) {
  } else if (truth_ && truth_->peek() && truth_->peek()->t == t) {
    takePose(event);
  } else {
    takeImage(event);
  }
  return true;
}

double Recording::progress() const {
  if (until_ != kEnd && until_ > from_ && from_ > 0) {
    return std::clamp(static_cast<double>(now_ - from_) / static_cast<double>(until_ - from_), 0.0,
                      1.0);
  }
  if (!cameras_.empty()) return cameras_[0].rows->progress();
  if (imu_) return imu_->progress();
  return !ranges_.empty() ? ranges_[0].rows->progress() : truth_ ? truth_->progress() : 1;
}

}  // namespace vir::euroc
