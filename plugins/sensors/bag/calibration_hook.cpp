#include "calibration_hook.h"

#include <algorithm>

#include "camera_choice.h"
#include "companion_ini.h"
#include "vir/formats/calibration_file.h"

namespace vir::bag {
namespace {

using formats::CalibratedCamera;
using formats::CalibrationFile;

bool names(const CalibratedCamera& c, const CameraSetup& camera) {
  return !c.topic.empty() && baseOf(c.topic) == baseOf(camera.topic);
}

/// The one that names the topic, else the one at this place if it names no other of `cameras`.
const CalibratedCamera* cameraFor(const CalibrationFile& file,
                                  const std::vector<CameraSetup>& cameras, std::size_t place) {
  for (const CalibratedCamera& c : file.cameras) {
    if (names(c, cameras[place])) return &c;
  }
  if (place >= file.cameras.size()) return nullptr;
  const CalibratedCamera& there = file.cameras[place];
  const bool taken = std::any_of(cameras.begin(), cameras.end(),
                                 [&](const CameraSetup& c) { return names(there, c); });
  return taken ? nullptr : &there;
}

}  // namespace

CalibratedTopics calibratedTopics(const std::string& path) {
  CalibratedTopics out;
  if (path.empty()) return out;
  const CalibrationFile file = formats::readCalibrationFile(path);
  for (const CalibratedCamera& c : file.cameras) {
    if (!c.topic.empty()) out.cameras.push_back(c.topic);
  }
  out.imu = file.imu_topic;
  return out;
}

CalibrationExtras applyCalibrationFile(const std::string& path, std::vector<CameraSetup>* cameras,
                                       ProblemLog* log) {
  const CalibrationFile file = formats::readCalibrationFile(path);
  for (const std::string& note : file.notes) log->note(path + ": " + note);
  CalibrationExtras extras;
  if (file.imu_noise) {
    extras.ini += "// Noise of the IMU, taken from " + path + "\n" + imuSection(*file.imu_noise);
  }
  std::vector<std::optional<double>> offsets(cameras->size());
  for (CameraSetup& c : *cameras) {
    const auto place = static_cast<std::size_t>(&c - cameras->data());
    const CalibratedCamera* found = cameraFor(file, *cameras, place);
    if (found == nullptr) {
      log->note(path + ": says nothing of the camera " + c.topic);
      continue;
    }
    log->note(c.topic + ": calibration from " + path + " (" + found->label + ")");
    c.intrinsics = found->camera;
    c.has_intrinsics = true;
    if (found->T_B_C) c.T_B_C = *found->T_B_C, c.has_place = true;
    offsets[place] = found->time_offset_s;
  }
  if (!offsets.empty()) {
    extras.ini += cameraSection(offsets[0], formats::otherTimeOffsets(offsets));
  }
  return extras;
}

}  // namespace vir::bag
