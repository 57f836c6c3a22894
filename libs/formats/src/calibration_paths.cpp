/// Several files of calibration that are used as one.
#include <algorithm>
#include <filesystem>

#include "vir/formats/calibration_file.h"

namespace vir::formats {
namespace fs = std::filesystem;

std::vector<std::string> calibrationPaths(const std::string& paths, const std::string& folder) {
  std::vector<std::string> out;
  const auto add = [&](const std::string& path) {
    const bool relative = !folder.empty() && fs::path(path).is_relative();
    out.push_back(relative ? (fs::path(folder) / path).string() : path);
  };
  std::string rest = paths;
  while (!rest.empty()) {
    // Names may hold a colon too.
    std::size_t end = rest.find(kPathSeparator);
    for (; end != rest.npos; end = rest.find(kPathSeparator, end + 1)) {
      std::error_code ec;
      if (fs::is_regular_file(fs::path(folder) / rest.substr(0, end), ec)) break;
    }
    add(rest.substr(0, end));
    rest.erase(0, end == rest.npos ? end : end + 1);
  }
  return out;
}

void takeFrom(const CalibrationFile& other, CalibrationFile* file) {
  const auto refuseTwo = [&](bool both, const char* what) {
    if (!both) return;
    throw CalibrationError(file->path + " and " + other.path + " both hold " + what +
                           ": give one of the two, or one file with all of it");
  };
  refuseTwo(!file->cameras.empty() && !other.cameras.empty(), "cameras");
  refuseTwo(file->imu_noise && other.imu_noise, "the noise of the IMU");
  refuseTwo(file->imu_correction && other.imu_correction, "gains and axes of the IMU");
  file->path += kPathSeparator + other.path;
  if (file->format != other.format) file->format += ", " + other.format;
  if (file->cameras.empty()) file->cameras = other.cameras;
  if (!file->imu_noise) file->imu_noise = other.imu_noise;
  if (!file->imu_correction) file->imu_correction = other.imu_correction;
  if (!file->imu_rate_hz) file->imu_rate_hz = other.imu_rate_hz;
  if (file->imu_topic.empty()) file->imu_topic = other.imu_topic;
  for (const std::string& note : other.notes) {
    const bool said = std::find(file->notes.begin(), file->notes.end(), note) != file->notes.end();
    if (!said) file->notes.push_back(note);
  }
}

}  // namespace vir::formats
