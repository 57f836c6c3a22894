#include "calibration_hook.h"

#include "companion_ini.h"
#include "vir/formats/calibration_file.h"

namespace vir::bag {
namespace {

using formats::CalibratedCamera;
using formats::CalibrationFile;

/// The one that names the topic, else the one at this place.
const CalibratedCamera* cameraFor(const CalibrationFile& file, const std::string& topic,
                                  std::size_t place) {
  for (const CalibratedCamera& c : file.cameras) {
    if (!c.topic.empty() && c.topic == topic) return &c;
  }
  return place < file.cameras.size() ? &file.cameras[place] : nullptr;
}

}  // namespace

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
    const CalibratedCamera* found = cameraFor(file, c.topic, place);
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
