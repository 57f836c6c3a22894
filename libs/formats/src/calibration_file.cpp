#include "vir/formats/calibration_file.h"

#include <algorithm>
#include <cctype>
#include <cstdio>

#include "camera_section.h"

namespace vir::formats {
namespace {

bool startsWith(const std::string& text, const std::string& head) {
  return text.compare(0, head.size(), head) == 0;
}

/// `cam0`, `imu1`: the blocks of Kalibr.
bool isBlockOf(const std::string& key, const std::string& kind) {
  return startsWith(key, kind) && key.size() > kind.size() &&
         std::all_of(key.begin() + static_cast<std::ptrdiff_t>(kind.size()), key.end(),
                     [](unsigned char c) { return std::isdigit(c) != 0; });
}

bool isKalibr(const YamlSection& root) {
  const auto keys = root.keys();
  return std::any_of(keys.begin(), keys.end(), [&](const std::string& key) {
    return (isBlockOf(key, "cam") || isBlockOf(key, "imu")) && root.isMap(key);
  });
}

bool isOrbSlam(const YamlSection& root) {
  const auto keys = root.keys();
  return std::any_of(keys.begin(), keys.end(), [](const std::string& key) {
    return startsWith(key, "Camera.") || startsWith(key, "Camera1.");
  });
}

[[noreturn]] void failUnknown(const YamlSection& root) {
  std::string keys;
  for (const std::string& key : root.keys()) {
    if (keys.size() > 200) {
      keys += ", ...";
      break;
    }
    keys += (keys.empty() ? "" : ", ") + key.substr(0, 40);
  }
  root.fail(
      "is no calibration of a known kind. `resolution` is missing, and so are the blocks and keys "
      "of Kalibr (cam0, imu0), ORB-SLAM3 (Camera1.fx), VINS (model_type), ROS and OpenCV "
      "(camera_matrix). It holds: " +
      keys);
}

}  // namespace

const CalibratedCamera* CalibrationFile::camera(const std::string& label) const {
  for (const CalibratedCamera& c : cameras) {
    if (c.label == label) return &c;
  }
  return nullptr;
}

namespace {

CalibrationFile readKnown(const YamlSection& root) {
  const auto has = [&](const std::vector<std::string>& keys) {
    return !root.firstOf(keys).empty();
  };
  if (isKalibr(root)) return readKalibr(root);
  if (has({"relative_config_imucam", "relative_config_imu"})) return readOpenVinsConfig(root);
  if (has({"model_type", "cam0_calib", "body_T_cam0", "extrinsicRotation"})) return readVins(root);
  if (isOrbSlam(root)) return readOrbSlam(root);
  if (has({"camera_matrix", "Camera_Matrix"})) return readCameraInfo(root);
  if (has({"intrinsics", "resolution", "gyroscope_noise_density", "accelerometer_noise_density"})) {
    return readSensorYaml(root);
  }
  failUnknown(root);
}

}  // namespace

CalibrationFile readCalibrationFile(const std::string& path) {
  const std::vector<std::string> paths = calibrationPaths(path);
  if (paths.size() > 1) {
    CalibrationFile all = readCalibrationFile(paths.front());
    for (std::size_t i = 1; i < paths.size(); ++i) takeFrom(readCalibrationFile(paths[i]), &all);
    return all;
  }
  CalibrationFile file = readKnown(YamlSection::load(path));
  for (const CalibratedCamera& c : file.cameras) {
    const std::string note =
        "the size of the images of " + c.label + " is not in the file: it is taken from the images";
    const bool said = std::find(file.notes.begin(), file.notes.end(), note) != file.notes.end();
    if (c.camera.width == 0 && !said) file.notes.push_back(note);
  }
  return file;
}

void takeSizeOfImages(int width, int height, CameraCalibration* camera) {
  const auto middle = [](double centre, int size) {
    return centre > 0.25 * size && centre < 0.75 * size;
  };
  if (width < 1 || height < 1) {
    throw CalibrationError(
        "the calibration does not say of which size its images are, and no image is there to tell: "
        "add the size to it");
  }
  if (!middle(camera->cx, width) || !middle(camera->cy, height)) {
    char text[200];
    std::snprintf(
        text, sizeof text,
        "the calibration does not say of which size its images are, and its principal "
        "point (%.1f, %.1f) is not near the middle of images of %dx%d: add the size to it",
        camera->cx, camera->cy, width, height);
    throw CalibrationError(text);
  }
  camera->width = width;
  camera->height = height;
}

}  // namespace vir::formats
