/// VINS-Mono and VINS-Fusion: a file per camera (model_type ...), named by the one of the estimator
/// (body_T_cam0, td, acc_n), or both in one.
#include <filesystem>

#include "camera_section.h"

namespace vir::formats {
namespace fs = std::filesystem;
namespace {

CameraCalibration readIntrinsics(const YamlSection& root) {
  CameraCalibration c;
  setSizeIfGiven(root, "image_width", "image_height", &c);
  const std::string model = root.text("model_type");
  const YamlSection p = root.child("projection_parameters");
  const auto of = [](const YamlSection& s, std::initializer_list<const char*> keys) {
    std::vector<double> out;
    for (const char* key : keys) out.push_back(s.number(key));
    return out;
  };
  std::vector<double> k;
  if (model == "PINHOLE") {
    k = of(p, {"fx", "fy", "cx", "cy"});
    c.distortion = Distortion::radtan;
  } else if (model == "KANNALA_BRANDT") {
    k = of(p, {"mu", "mv", "u0", "v0"});
    c.distortion = Distortion::equidistant;
    setDistortion(p, "k2", of(p, {"k2", "k3", "k4", "k5"}), &c);
  } else if (model == "MEI") {
    k = of(p, {"gamma1", "gamma2", "u0", "v0"});
    c.distortion = Distortion::omni;
    c.dist[0] = root.child("mirror_parameters").number("xi");
  } else {
    root.fail("model_type is `" + model + "`; known are PINHOLE, KANNALA_BRANDT and MEI");
  }
  if (model != "KANNALA_BRANDT") {
    const YamlSection d = root.child("distortion_parameters");
    setDistortion(d, "k1", of(d, {"k1", "k2", "p1", "p2"}), &c);
  }
  c.fx = k[0], c.fy = k[1], c.cx = k[2], c.cy = k[3];
  checkIntrinsics(root, "projection_parameters", c);
  return c;
}

std::optional<Pose> readPose(const YamlSection& root, int index) {
  const std::string key = "body_T_cam" + std::to_string(index);
  if (root.has(key)) return root.pose(key);
  if (index > 0 || !root.has("extrinsicRotation")) return std::nullopt;
  const auto t = root.numbers("extrinsicTranslation");
  if (t.size() != 3) root.fail("`extrinsicTranslation` must be three numbers");
  return Pose(Quat(root.rotation("extrinsicRotation")).normalized(), Vec3(t[0], t[1], t[2]));
}

}  // namespace

CalibrationFile readVins(const YamlSection& root) {
  CalibrationFile file;
  file.path = root.path();
  file.format = "VINS";
  const fs::path folder = fs::path(root.path()).parent_path();
  for (int i = 0; i < 8; ++i) {
    const std::string number = std::to_string(i);
    const bool here = i == 0 && root.has("model_type");
    const std::string other = root.text("cam" + number + "_calib");
    if (!here && other.empty()) break;
    CalibratedCamera c;
    c.label = "cam" + number;
    c.camera = readIntrinsics(here ? root : YamlSection::load((folder / other).string()));
    c.T_B_C = readPose(root, i);
    c.time_offset_s = readTimeShift(root, "td", &file);
    c.topic =
        root.text(i == 0 && root.has("image_topic") ? "image_topic" : "image" + number + "_topic");
    file.cameras.push_back(c);
  }
  if (file.cameras.empty()) {
    file.notes.push_back("it names no file of a camera (cam0_calib): there are no intrinsics");
  }
  file.imu_topic = root.text("imu_topic");
  if (root.has("acc_n") || root.has("gyr_n")) {
    // They are the standard deviation of a reading, and are usually set far above the sensor's.
    file.notes.push_back(
        "acc_n, gyr_n, acc_w and gyr_w are no densities and are not used: give the IMU's in [Imu]");
  }
  noteMissingPoses("add body_T_cam0 to it, or give VINS' main file, which names this one", &file);
  return file;
}

}  // namespace vir::formats
