/// One sensor per file: ROS' camera_info, OpenCV's calibration samples, EuRoC's sensor.yaml and
/// Kalibr's imu.yaml.
#include "camera_section.h"

namespace vir::formats {
namespace {

/// By the number of coefficients, where the file does not say.
Distortion lensByCount(const YamlSection& root, const std::vector<double>& d) {
  if (root.optionalNumber("fisheye_model").value_or(0) != 0) return Distortion::equidistant;
  std::size_t n = d.size();
  while (n > 0 && d[n - 1] == 0) --n;
  if (n == 0) return Distortion::none;
  return n > 5 ? Distortion::rational : Distortion::radtan;
}

}  // namespace

CalibrationFile readCameraInfo(const YamlSection& root) {
  CalibrationFile file;
  file.path = root.path();
  file.format = "ROS camera_info or OpenCV";
  CalibratedCamera c;
  c.label = "cam0";
  const std::string width = root.firstOf({"image_width", "image_Width", "width"});
  const std::string height = root.firstOf({"image_height", "image_Height", "height"});
  if (width.empty() != height.empty()) root.fail("`image_width` or `image_height` is missing");
  if (!width.empty()) setSizeIfGiven(root, width, height, &c.camera);
  const std::string matrix = root.firstOf({"camera_matrix", "Camera_Matrix"});
  const auto k = root.numbers(matrix);
  if (k.size() != 9) root.fail("`" + matrix + "` must be 3x3");
  c.camera.fx = k[0], c.camera.fy = k[4], c.camera.cx = k[2], c.camera.cy = k[5];
  const std::string lens =
      root.firstOf({"distortion_coefficients", "Distortion_Coefficients", "distortion_coeffs"});
  std::vector<double> d;
  if (!lens.empty()) d = root.numbers(lens);
  if (root.has("distortion_model")) {
    c.camera.distortion = distortionOf(root, root.text("distortion_model"));
  } else {
    c.camera.distortion = lensByCount(root, d);
    file.notes.push_back("distortion_model is not in the file; by its " + std::to_string(d.size()) +
                         " coefficients it was taken for " +
                         (c.camera.distortion == Distortion::none          ? "none"
                          : c.camera.distortion == Distortion::rational    ? "rational_polynomial"
                          : c.camera.distortion == Distortion::equidistant ? "equidistant"
                                                                           : "plumb_bob"));
  }
  if (c.camera.distortion != Distortion::none) setDistortion(root, lens, d, &c.camera);
  checkIntrinsics(root, matrix, c.camera);
  const std::string pose = root.firstOf({"T_BS", "T_imu_cam"});
  if (!pose.empty()) c.T_B_C = root.pose(pose);
  if (root.has("T_cam_imu")) c.T_B_C = root.pose("T_cam_imu").inverse();
  file.cameras.push_back(c);
  noteMissingPoses("add T_BS (camera to IMU, 4x4 row by row) to it", &file);
  return file;
}

CalibrationFile readSensorYaml(const YamlSection& root) {
  CalibrationFile file;
  file.path = root.path();
  const bool camera = !root.firstOf({"intrinsics", "resolution"}).empty();
  file.format = camera ? "EuRoC sensor.yaml" : "IMU noise";
  if (!camera) {
    readImuNoise(root, &file);
    return file;
  }
  CalibratedCamera c;
  c.label = "cam0";
  c.camera = readListedCamera(root);
  c.topic = root.text("rostopic");
  if (root.has("T_BS")) c.T_B_C = root.pose("T_BS");
  if (root.has("T_cam_imu")) c.T_B_C = root.pose("T_cam_imu").inverse();
  c.time_offset_s = readTimeShift(root, "timeshift_cam_imu", &file);
  file.cameras.push_back(c);
  noteMissingPoses("add T_BS (camera to IMU, 4x4 row by row) to it", &file);
  return file;
}

}  // namespace vir::formats
