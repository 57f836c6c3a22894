/// Kalibr's camchain.yaml, camchain-imucam.yaml and imu.yaml; OpenVINS writes the same with
/// T_imu_cam; the calibration.yaml of a run is one with keys of its own beside.
#include <algorithm>
#include <cmath>
#include <cstdio>
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

/// A standard deviation, or a number of its kind; the bounds are those of the setting it becomes.
std::optional<double> bounded(const YamlSection& section, const std::string& key, double least,
                              double most) {
  const std::optional<double> v = section.optionalNumber(key);
  if (v && !(*v >= least && *v <= most)) {
    char text[96];
    std::snprintf(text, sizeof text, "` is %g; allowed: a number from %g to %g", *v, least, most);
    section.fail("`" + section.named(key) + text);
  }
  return v;
}

/// What the calibration.yaml of a run says beside Kalibr's.
void readSigma(const YamlSection& section, CalibratedCamera* c) {
  c->readout_s = bounded(section, "readout_s", -0.2, 0.2);
  CameraSigma& s = c->sigma;
  s.readout_s = bounded(section, "readout_sigma_s", 1e-7, 0.2);
  s.time_offset_s = bounded(section, "timeshift_cam_imu_sigma", 1e-7, 1);
  s.aspect = bounded(section, "aspect_sigma", 1e-6, 0.5);
  s.distortion = bounded(section, "distortion_sigma", 1e-7, 1);
  if (section.isMap("T_cam_imu_sigma")) {  // other files have lists of that name
    const YamlSection pose = section.child("T_cam_imu_sigma");
    s.position_m = bounded(pose, "position_m", 1e-6, 10);
    s.rotation_rad = bounded(pose, "rotation_rad", 1e-6, 3);
  }
  const char* const key = "focal_and_centre_sigma";
  if (!section.has(key)) return;
  const std::vector<double> v = section.numbers(key);
  const bool good = v.size() == 4 && *std::min_element(v.begin(), v.end()) > 0;
  if (good) s.focal = v[0] / c->camera.fx, s.centre_px = std::max(v[2], v[3]);
  if (!good || *s.focal < 1e-6 || *s.focal > 0.5 || *s.centre_px < 1e-4 || *s.centre_px > 1000) {
    section.fail("`" + section.named(key) +
                 "` must be four standard deviations [px]: of fx, fy (at most half of it), cx, cy");
  }
}

Vec3 threeSmall(const YamlSection& section, const std::string& key) {
  const std::vector<double> v = section.numbers(key);
  const auto small = [](double x) { return std::abs(x) <= 0.5; };
  if (v.size() != 3 || !std::all_of(v.begin(), v.end(), small)) {
    section.fail("`" + section.named(key) + "` must be three numbers from -0.5 to 0.5");
  }
  return {v[0], v[1], v[2]};
}

ImuCorrection readInertial(const YamlSection& section) {
  ImuCorrection out;
  out.gyro_gain = threeSmall(section, "gyro_gain");
  out.gyro_axes_rad = threeSmall(section, "gyro_axes_rad");
  out.acc_gain = threeSmall(section, "acc_gain");
  out.gyro_gain_sigma = bounded(section, "gyro_gain_sigma", 1e-7, 0.5);
  out.gyro_axes_sigma_rad = bounded(section, "gyro_axes_sigma_rad", 1e-7, 0.5);
  out.acc_gain_sigma = bounded(section, "acc_gain_sigma", 1e-7, 0.5);
  return out;
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
    c.time_offset_s = readTimeShift(section, "timeshift_cam_imu", &file);
    readSigma(section, &c);
    c.topic = section.text("rostopic");
    file.cameras.push_back(c);
  }
  const auto imus = blocks(root, "imu");
  if (!imus.empty()) readImuNoise(root.child(imus.front()), &file);
  if (imus.size() > 1) {
    file.notes.push_back("of " + std::to_string(imus.size()) + " IMUs " + imus.front() +
                         " is used");
  }
  if (root.has("inertial")) file.imu_correction = readInertial(root.child("inertial"));
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
