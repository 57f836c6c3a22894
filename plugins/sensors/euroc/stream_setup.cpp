#include "stream_setup.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "camera_scaling.h"
#include "image_list.h"
#include "imu_units.h"
#include "input_error.h"
#include "video_frames.h"
#include "vir/core/length_units.h"
#include "vir/core/parse_number.h"
#include "vir/formats/calibration_file.h"

namespace vir::euroc {

Units unitsOf(const EurocOptions& o) {
  Units u;
  u.acc = accelerationUnit(o.acc_unit);
  u.gyro = rateUnit(o.gyro_unit);
  if (const auto unit = lengthUnitOf(o.range_unit)) u.range = *unit;
  u.range_factor = o.range_factor;
  u.imu_offset = fromSeconds(o.imu_time_offset_s);
  u.range_offset = fromSeconds(o.range_time_offset_s);
  u.guess_acc = o.section == "csv";
  return u;
}

namespace {

/// How far the frames of a video are turned, clockwise [deg].
int turnOf(const EurocOptions& o) {
  int turn_deg = 0;
  parseNumber(o.turn_video, &turn_deg);  // describe() allows whole numbers only
  return turn_deg;
}

/// The file's times begin with 0, whatever the IMU's clock is. Both are taken to have begun
/// together unless the IMU's stamps lie within the video's.
TimeNs startOfVideo(const EurocOptions& o, const std::string& path, std::optional<TimeNs> imu_start,
                    ProblemLog* log) {
  TimeNs start = 0;
  if (o.video_start != "auto") {
    tables::parseStamp(o.video_start, tables::StampUnit::seconds, &start);
    return start;
  }
  const VideoInfo info = lookAtVideo(path, turnOf(o));
  const double length_s = info.rate_hz > 0 ? static_cast<double>(info.frames) / info.rate_hz : 0;
  if (imu_start && toSeconds(*imu_start) > length_s) start = *imu_start;
  char text[400];
  std::snprintf(text, sizeof text,
                ": its times count from its beginning; the first frame was put at %.3f s%s. "
                "video_start = SECONDS on the IMU's clock sets it. It must be right to 0.2 s: what "
                "is left of a constant offset a run finds by itself, and `vir-slam check` tells",
                toSeconds(start), start > 0 ? ", where the IMU begins" : "");
  log->note(path + text);
  return start;
}

/// Some images, spread over all of the list, as full names.
std::vector<std::string> someImages(const CameraFiles& camera) {
  // Every n-th of the list, n doubled whenever there are too many.
  constexpr std::size_t kMost = 16;
  ProblemLog silent;
  const auto list = openImages(camera, &silent);
  std::vector<std::string> files;
  for (std::size_t i = 0, step = 1; list->peek() != nullptr; ++i, list->pop()) {
    if (i % step != 0) continue;
    files.push_back(list->peek()->file);
    if (files.size() < kMost) continue;
    for (std::size_t k = 0; 2 * k < files.size(); ++k) files[k] = files[2 * k];
    files.resize(files.size() / 2);
    step *= 2;
  }
  for (std::string& file : files) file = imageFile(camera.dir, file);
  return files;
}

}  // namespace

std::unique_ptr<RowStream<ImageRow>> openCameraImages(const EurocOptions& o,
                                                      const CameraFiles& files,
                                                      std::optional<TimeNs> imu_start,
                                                      ProblemLog* log) {
  if (files.video.empty()) return openImages(files, log);
  VideoTimes times;
  times.table = files.list;
  if (times.table.empty()) times.start = startOfVideo(o, files.video, imu_start, log);
  return openVideo(files.video, times, turnOf(o), log);
}

void fitToImages(const EurocOptions& o, CameraStream* camera, ProblemLog* log) {
  const int wanted_width = o.width_px;
  ImageSurvey survey;
  if (camera->files.video.empty()) {
    survey = surveyImages(someImages(camera->files));
  } else {
    const VideoInfo info = lookAtVideo(camera->files.video, turnOf(o));
    survey.width = info.width;
    survey.height = info.height;
  }
  camera->stretch = stretchOf(survey);
  const std::string& dir = camera->files.dir;
  if (!camera->stretch.said.empty()) log->note(dir + ": " + camera->stretch.said);
  CameraCalibration& c = camera->calibration.camera;
  char text[160];
  if (c.width == 0) {
    try {
      formats::takeSizeOfImages(survey.width, survey.height, &c);
    } catch (const formats::CalibrationError& e) {
      throw InputError(dir + ": " + e.what());
    }
    std::snprintf(text, sizeof text, ": the size of the images, %dx%d, taken from the first one",
                  c.width, c.height);
    log->note(dir + text);
  }
  if (survey.width != 0 && (survey.width != c.width || survey.height != c.height)) {
    const double sx = static_cast<double>(survey.width) / c.width;
    const double sy = static_cast<double>(survey.height) / c.height;
    if (std::abs(sx / sy - 1) <= 0.005) {  // else the images will be refused one by one
      std::snprintf(
          text, sizeof text,
          ": images of %dx%d, the calibration is of %dx%d: its intrinsics were scaled by %.4g",
          survey.width, survey.height, c.width, c.height, sx);
      log->note(dir + text);
      scaleTo(survey.width, survey.height, &c);
    } else if (survey.width == c.height && survey.height == c.width) {
      std::snprintf(text, sizeof text,
                    ": images of %dx%d, the calibration is of %dx%d: was it made with turned ones?",
                    survey.width, survey.height, c.width, c.height);
      log->note(dir + text + (camera->files.video.empty() ? "" : " (turn_video)"));
    }
  }
  camera->file_width = c.width;
  camera->file_height = c.height;
  if (wanted_width <= 0 || wanted_width == c.width) return;
  const int height = std::max(
      1, static_cast<int>(std::lround(static_cast<double>(c.height) * wanted_width / c.width)));
  std::snprintf(text, sizeof text, ": images of %dx%d are resized to %dx%d, and the calibration",
                c.width, c.height, wanted_width, height);
  log->note(dir + text);
  scaleTo(wanted_width, height, &c);
}

}  // namespace vir::euroc
