#include "recording.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>

#include "input_error.h"

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
void requireRows(const RowCursor<Row>& c, const ProblemLog& log) {
  if (c.peek()) return;
  std::string why;
  for (const char* kind :
       {"malformed", "not_finite", "implausible", "cut_line", "too_late", "repeated"}) {
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

Recording::Recording(const EurocOptions& o, ProblemLog* log) : log_(log) {
  validate(o);
  folder_ = findFolder(o.source, o.camera);
  openCalibration(o);
  openStreams(o);
}

void Recording::openCalibration(const EurocOptions& o) {
  const std::string imu_yaml = folder_.imu_dir + "/sensor.yaml";
  if (fs::exists(imu_yaml)) {
    imu_calibration_ = readImuYaml(imu_yaml, log_);
  } else {
    log_->note(imu_yaml +
               ": missing; the IMU is taken as the body frame, noise densities as unknown");
  }
  const Pose& T_B_I = imu_calibration_.T_B_I;
  if (!isIdentity(T_B_I)) {
    log_->note(imu_yaml +
               ": T_BS is not the identity; body is the IMU here, so camera, antenna and ground "
               "truth were moved to the IMU's frame");
  }
  if (!folder_.camera_dir.empty()) openCamera(o);
  range_sigma_m_ = o.range_sigma_m;
  antenna_ = Vec3(o.lever_arm_m[0], o.lever_arm_m[1], o.lever_arm_m[2]);
  if (!folder_.uwb_dir.empty() && o.read_ranges && !o.simulate_ranges) {
    const std::string uwb_yaml = folder_.uwb_dir + "/sensor.yaml";
    if (fs::exists(uwb_yaml)) {
      const UwbYaml uwb = readUwbYaml(uwb_yaml);
      antenna_ = T_B_I.inverse() * uwb.T_B_U.p;
      range_sigma_m_ = uwb.sigma_m.value_or(o.range_sigma_m);
    } else {
      log_->note(uwb_yaml + ": missing; lever_arm_m and range_sigma_m of the settings are used");
    }
  }
  T_S_B_truth_ = T_B_I;
  if (const std::string yaml = folder_.ground_truth_dir + "/sensor.yaml";
      !folder_.ground_truth_file.empty() && fs::exists(yaml)) {
    T_S_B_truth_ = readSensorPose(yaml).inverse() * T_B_I;
  }
}

void Recording::openCamera(const EurocOptions& o) {
  const std::string yaml = folder_.camera_dir + "/sensor.yaml";
  GivenCalibration given;
  if (!o.calibration.empty()) {
    given = readGivenCalibration(o.calibration, o.camera);
    for (const std::string& note : given.notes) log_->note(o.calibration + ": " + note);
  }
  if (!given.camera || !given.T_B_C) {
    camera_ = readCameraYaml(yaml);
    camera_->T_B_C = imu_calibration_.T_B_I.inverse() * camera_->T_B_C;
  } else {
    camera_.emplace();
  }
  std::string what;
  const auto take = [&](const char* part) {
    what += (what.empty() ? "" : ", ") + std::string(part);
  };
  if (given.camera) camera_->camera = *given.camera, take("the camera's intrinsics");
  if (given.T_B_C) camera_->T_B_C = *given.T_B_C, take("its pose on the IMU");
  if (given.time_offset_s) time_offset_s_ = given.time_offset_s, take("its time offset");
  if (given.imu) {
    const Pose T_B_I = imu_calibration_.T_B_I;
    imu_calibration_ = *given.imu;
    imu_calibration_.T_B_I = T_B_I;
    take("the IMU's noise");
  }
  if (!what.empty()) log_->note("from " + o.calibration + ": " + what);
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
  const std::string table = folder_.uwb_dir + "/anchors_truth.csv";
  if (folder_.uwb_dir.empty() || !o.read_ranges || !fs::exists(table)) return;
  true_anchors_ = readAnchorTable(table, &anchor_names_, log_);
}

std::vector<std::string> Recording::someImages() const {
  // Every n-th of the list, n doubled whenever there are too many.
  constexpr std::size_t kMost = 16;
  ProblemLog silent;
  const auto list = euroc::openImageList(folder_.camera_dir + "/data.csv", &silent);
  std::vector<std::string> files;
  for (std::size_t i = 0, step = 1; list->peek() != nullptr; ++i, list->pop()) {
    if (i % step != 0) continue;
    files.push_back(list->peek()->file);
    if (files.size() < kMost) continue;
    for (std::size_t k = 0; 2 * k < files.size(); ++k) files[k] = files[2 * k];
    files.resize(files.size() / 2);
    step *= 2;
  }
  for (std::string& file : files) file = imageFile(folder_.camera_dir, file);
  return files;
}

void Recording::fitToImages() {
  const ImageSurvey survey = surveyImages(someImages());
  stretch_ = stretchOf(survey);
  if (!stretch_.said.empty()) log_->note(folder_.camera_dir + ": " + stretch_.said);
  CameraCalibration& c = camera_->camera;
  if (survey.width == 0 || (survey.width == c.width && survey.height == c.height)) return;
  const double sx = static_cast<double>(survey.width) / c.width;
  const double sy = static_cast<double>(survey.height) / c.height;
  if (std::abs(sx / sy - 1) > 0.005) return;  // the images will be refused one by one
  char text[160];
  std::snprintf(
      text, sizeof text,
      ": images of %dx%d, the calibration is of %dx%d: its intrinsics were scaled by %.4g",
      survey.width, survey.height, c.width, c.height, sx);
  log_->note(folder_.camera_dir + text);
  c.width = survey.width;
  c.height = survey.height;
  c.fx *= sx, c.fy *= sy;
  // The middle of the first pixel is (0, 0).
  c.cx = (c.cx + 0.5) * sx - 0.5, c.cy = (c.cy + 0.5) * sy - 0.5;
}

void Recording::skipOtherAntennas() {
  if (wanted_antenna_.empty() || !ranges_) return;
  while (ranges_->peek() != nullptr && ranges_->peek()->antenna != wanted_antenna_) {
    log_->count("range_of_another_antenna");
    ranges_->pop();
  }
}

void Recording::noteAnchorNames() {
  for (const auto& [name, number] : anchor_names_.mapped()) {
    log_->note("anchor " + name + " is " + std::to_string(number) + " in the rawlog");
  }
}

void Recording::openStreams(const EurocOptions& o) {
  findTrueAnchors(o);
  imu_ = openImu(folder_.imu_dir + "/data.csv", log_);
  requireRows(*imu_, *log_);
  TimeNs origin = imu_->peek()->t;
  if (camera_) {
    images_ = openImageList(folder_.camera_dir + "/data.csv", log_);
    requireRows(*images_, *log_);
    fitToImages();
    origin = images_->peek()->t;
  }
  const bool has_truth = !folder_.ground_truth_file.empty();
  if (!has_truth)
    log_->note(folder_.mav0 + ": no ground truth (state_groundtruth_estimate0 or mocap0)");
  if (has_truth && o.read_gt) truth_ = openGroundTruth(folder_.ground_truth_file, log_);
  if (o.simulate_ranges) {
    if (!has_truth)
      throw InputError("[euroc] simulate_ranges = true needs a ground truth in " + folder_.mav0);
    if (!folder_.uwb_dir.empty())
      log_->note(folder_.uwb_dir + ": not read, ranges are drawn instead");
    drawn_ = std::make_unique<RangeSimulator>(
        o, openGroundTruth(folder_.ground_truth_file, &silent_), T_S_B_truth_, log_);
  } else if (!folder_.uwb_dir.empty() && o.read_ranges) {
    ranges_ = openRanges(folder_.uwb_dir + "/data.csv", &anchor_names_, log_);
    wanted_antenna_ = o.antenna;
    skipOtherAntennas();
  }

  from_ = 0;
  until_ = kEnd;
  const double longest = toSeconds(kEnd - origin) / 2;
  if (o.start_s > 0) from_ = origin + fromSeconds(std::min(o.start_s, longest));
  if (o.max_duration_s > 0) {
    until_ = std::max(from_, origin) + fromSeconds(std::min(o.max_duration_s, longest));
  }
  skipUntil(imu_.get(), from_);
  skipUntil(images_.get(), from_);
  skipUntil(ranges_.get(), from_);
  skipOtherAntennas();
  skipUntil(truth_.get(), from_);
  skipUntil(drawn_.get(), from_);
  const bool nothing = camera_ ? !images_->peek() : !imu_->peek();
  if (nothing) {
    throw InputError("[euroc] start_s = " + std::to_string(o.start_s) +
                     " lies behind the end of the recording");
  }
  now_ = from_;
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

bool Recording::next(Event* event) {
  const TimeNs ti = imu_->peek() ? imu_->peek()->t : kEnd;
  const TimeNs tr = ranges_ && ranges_->peek() ? ranges_->peek()->t : kEnd;
  const TimeNs td = drawn_ && drawn_->peek() ? drawn_->peek()->t : kEnd;
  const TimeNs tg = truth_ && truth_->peek() ? truth_->peek()->t : kEnd;
  const TimeNs tc = images_ && images_->peek() ? images_->peek()->t : kEnd;
  const TimeNs t = std::min({ti, tr, td, tg, tc});
  if (t == kEnd || t > until_) {
    noteAnchorNames();
    return false;
  }
  event->t = now_ = t;
  event->where.clear();
  if (t == ti) {
    event->what = *imu_->peek();
    imu_->pop();
    watchGap(t, &last_imu_, "imu_gap", imu_->path());
  } else if (t == tr) {
    event->what = *ranges_->peek();
    ranges_->pop();
    skipOtherAntennas();
  } else if (t == td) {
    const SimulatedRange& r = *drawn_->peek();
    event->what = RangeRow{r.t, r.anchor, r.range_m};
    if (!r.line_of_sight) log_->count("range_drawn_without_line_of_sight");
    drawn_->pop();
  } else if (t == tg) {
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
  } else {
    event->what = *images_->peek();
    event->where = images_->where();
    images_->pop();
    watchGap(t, &last_image_, "image_gap", images_->path());
  }
  return true;
}

double Recording::progress() const {
  if (until_ != kEnd && until_ > from_ && from_ > 0) {
    return std::clamp(static_cast<double>(now_ - from_) / static_cast<double>(until_ - from_), 0.0,
                      1.0);
  }
  return images_ ? images_->progress() : imu_->progress();
}

}  // namespace vir::euroc
