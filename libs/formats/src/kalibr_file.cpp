/// Kalibr's camchain.yaml, camchain-imucam.yaml and imu.yaml; OpenVINS writes the same with
/// T_imu_cam; the calibration.yaml of a run is one with keys of its own beside.
#include <algorithm>
#include <filesystem>

#include "camera_section.h"

namespace vir::formats {
namespace fs = std::filesystem;
namespace {

/// `cam0`, `cam1`, ...: in order of their numbers.
std::vector<std::string> blocks(const YamlSection& root, const std::string& kind) {
  std::vector<std::string> out;
  for (int i = 0; i < 64; ++i) {
    const std::string name = kind + std::to_string(i);
    if (root.isMap(name)) out.push_back(name);
  }
  return out;
}

void readPose(const YamlSection& section, const CalibratedCamera* before, CalibratedCamera* c) {
  // Kalibr's takes IMU coordinates to the camera; OpenVINS' and ours the other way.
  if (section.has("T_cam_imu")) {
    c->T_B_C = section.pose("T_cam_imu").inverse();
  } else if (section.has("T_imu_cam")) {
    c->T_B_C = section.pose("T_imu_cam");
  } else if (section.has("T_BS")) {
    c->T_B_C = section.pose("T_BS");
  } else if (before != nullptr && before->T_B_C && section.has("T_cn_cnm1")) {
    c->T_B_C = *before->T_B_C * section.pose("T_cn_cnm1").inverse();
  }
}

}  // namespace

CalibrationFile readKalibr(const YamlSection& root) {
  CalibrationFile file;
  file.path = root.path();
  file.format = "Kalibr";
  for (const std::string& name : blocks(root, "cam")) {
    const YamlSection section = root.child(name);
    CalibratedCamera c;
    c.label = name;
    c.camera = readListedCamera(section);
    readPose(section, file.cameras.empty() ? nullptr : &file.cameras.back(), &c);
    c.time_offset_s = section.optionalNumber("timeshift_cam_imu");
    c.topic = section.text("rostopic");
    file.cameras.push_back(c);
  }
  const auto imus = blocks(root, "imu");
  if (!imus.empty()) readImuNoise(root.child(imus.front()), &file);
  if (imus.size() > 1) {
    file.notes.push_back("of " + std::to_string(imus.size()) + " IMUs " + imus.front() +
                         " is used");
  }
  noteMissingPoses("add T_cam_imu to it (Kalibr's camchain-imucam.yaml has it)", &file);
  return file;
}

CalibrationFile readOpenVinsConfig(const YamlSection& root) {
  CalibrationFile file;
  const fs::path folder = fs::path(root.path()).parent_path();
  const std::string cameras = root.text("relative_config_imucam");
  if (!cameras.empty()) file = readKalibr(YamlSection::load((folder / cameras).string()));
  file.path = root.path();
  file.format = "OpenVINS";
  const std::string imu = root.text("relative_config_imu");
  if (imu.empty()) return file;
  const CalibrationFile other = readCalibrationFile((folder / imu).string());
  file.imu_noise = other.imu_noise;
  file.imu_rate_hz = other.imu_rate_hz;
  file.imu_topic = other.imu_topic;
  for (const CalibratedCamera& c : other.cameras) {
    if (file.camera(c.label) == nullptr) file.cameras.push_back(c);
  }
  file.notes.insert(file.notes.end(), other.notes.begin(), other.notes.end());
  return file;
}

}  // namespace vir::formats
