/// ORB-SLAM2 and 3: flat keys `Camera.fx`, `Camera1.fx`, `IMU.NoiseGyro`, `Tbc`.
#include "camera_section.h"

namespace vir::formats {
namespace {

Distortion lensOf(const YamlSection& root) {
  const std::string type = root.text("Camera.type");
  if (type.empty() || type == "PinHole") return Distortion::radtan;
  if (type == "Rectified") return Distortion::none;
  if (type == "KannalaBrandt8") return Distortion::equidistant;
  root.fail("Camera.type is `" + type + "`; known are PinHole, Rectified and KannalaBrandt8");
}

/// `key` of the camera, in the way of version 3 or of the ones before it.
CameraCalibration readIntrinsics(const YamlSection& root, const std::string& camera) {
  CameraCalibration c;
  c.distortion = lensOf(root);
  setSizeIfGiven(root, "Camera.width", "Camera.height", &c);
  const auto of = [&](const std::string& key) { return root.number(camera + "." + key); };
  c.fx = of("fx"), c.fy = of("fy"), c.cx = of("cx"), c.cy = of("cy");
  if (c.distortion == Distortion::radtan) {
    // Distortion is left out for images that are rectified already.
    const auto or0 = [&](const std::string& key) {
      return root.optionalNumber(camera + "." + key).value_or(0);
    };
    c.dist = {or0("k1"), or0("k2"), or0("p1"), or0("p2"), or0("k3")};
  }
  if (c.distortion == Distortion::equidistant) c.dist = {of("k1"), of("k2"), of("k3"), of("k4")};
  checkIntrinsics(root, camera + ".fx", c);
  return c;
}

void readNoise(const YamlSection& root, CalibrationFile* file) {
  file->imu_rate_hz = root.optionalNumber("IMU.Frequency");
  imu::ImuNoise n;
  const std::pair<const char*, double*> fields[] = {{"IMU.NoiseGyro", &n.gyro_noise_density},
                                                    {"IMU.GyroWalk", &n.gyro_random_walk},
                                                    {"IMU.NoiseAcc", &n.acc_noise_density},
                                                    {"IMU.AccWalk", &n.acc_random_walk}};
  for (const auto& [key, value] : fields) {
    *value = root.optionalNumber(key).value_or(0);
    if (*value <= 0) return;
  }
  file->imu_noise = n;
}

}  // namespace

CalibrationFile readOrbSlam(const YamlSection& root) {
  CalibrationFile file;
  file.path = root.path();
  file.format = "ORB-SLAM";
  CalibratedCamera first;
  first.label = "cam0";
  first.camera = readIntrinsics(root, root.has("Camera1.fx") ? "Camera1" : "Camera");
  const std::string pose = root.firstOf({"IMU.T_b_c1", "Tbc", "IMU.Tbc"});
  if (!pose.empty()) first.T_B_C = root.pose(pose);
  file.cameras.push_back(first);
  if (root.has("Camera2.fx")) {
    CalibratedCamera second;
    second.label = "cam1";
    second.camera = readIntrinsics(root, "Camera2");
    if (first.T_B_C && root.has("Stereo.T_c1_c2")) {
      second.T_B_C = *first.T_B_C * root.pose("Stereo.T_c1_c2");
    }
    file.cameras.push_back(second);
  }
  readNoise(root, &file);
  noteMissingPoses("add IMU.T_b_c1 to it", &file);
  return file;
}

}  // namespace vir::formats
