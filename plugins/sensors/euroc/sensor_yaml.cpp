#include "sensor_yaml.h"

#include <yaml-cpp/yaml.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <vector>

#include "input_error.h"

namespace vir::euroc {
namespace {

/// A rotation written with 3 decimals is still accepted (and made exact); a scale or a shear not.
constexpr double kRotationTolerance = 5e-3;

[[noreturn]] void fail(const std::string& path, const std::string& text) {
  throw InputError(path + ": " + text);
}

/// The document without the `%YAML:1.0` line of OpenCV's dialect, which is not YAML.
YAML::Node load(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) fail(path, "no such file, or not readable; the calibration is needed");
  std::ostringstream text;
  std::string line;
  bool first = true;
  while (std::getline(file, line)) {
    if (first && line.compare(0, 3, "\xEF\xBB\xBF") == 0) line.erase(0, 3);
    first = false;
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.compare(0, 5, "%YAML") == 0) continue;
    // YAML forbids tabs as indentation; hand-edited files have them.
    std::replace(line.begin(), line.end(), '\t', ' ');
    text << line << '\n';
  }
  try {
    YAML::Node node = YAML::Load(text.str());
    if (!node.IsMap()) fail(path, "is empty or holds no `key: value` lines");
    return node;
  } catch (const YAML::Exception& e) {
    fail(path, std::string("is not readable YAML: ") + e.what());
  }
}

double number(const std::string& path, const std::string& key, const YAML::Node& node) {
  try {
    const double v = node.as<double>();
    if (!std::isfinite(v)) fail(path, key + " is not finite");
    return v;
  } catch (const YAML::Exception&) {
    fail(path, key + " is not a number");
  }
}

void flatten(const std::string& path, const std::string& key, const YAML::Node& node,
             std::vector<double>* out) {
  if (node.IsSequence()) {
    for (const auto& child : node) flatten(path, key, child, out);
  } else {
    out->push_back(number(path, key, node));
  }
}

/// A list of numbers, nested or flat, or a matrix with a `data` list.
std::vector<double> numbers(const std::string& path, const YAML::Node& root,
                            const std::string& key) {
  YAML::Node node = root[key];
  if (!node) fail(path, "`" + key + "` is missing");
  if (node.IsMap()) node.reset(node["data"]);
  if (!node || !node.IsSequence()) fail(path, "`" + key + "` is not a list of numbers");
  std::vector<double> out;
  flatten(path, key, node, &out);
  return out;
}

Pose poseOf(const std::string& path, const YAML::Node& root, bool required) {
  if (!root["T_BS"]) {
    if (required) fail(path, "`T_BS` (sensor to body, 4x4) is missing");
    return {};
  }
  const std::vector<double> v = numbers(path, root, "T_BS");
  if (v.size() != 16) fail(path, "`T_BS` has " + std::to_string(v.size()) + " numbers, not 16");
  const Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> T(v.data());
  const Mat3 R = T.topLeftCorner<3, 3>();
  const Eigen::RowVector4d last(0, 0, 0, 1);
  const bool rotation =
      (R * R.transpose() - Mat3::Identity()).cwiseAbs().maxCoeff() < kRotationTolerance &&
      R.determinant() > 0;
  if (!rotation || (T.row(3) - last).cwiseAbs().maxCoeff() > 1e-6) {
    fail(path,
         "`T_BS` is not a rigid transform (the upper left 3x3 must be a rotation, the last row 0 0 "
         "0 1)");
  }
  // The nearest rotation: digits cut off in the file must not bend what is computed from it.
  const Eigen::JacobiSVD<Mat3> svd(R, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Mat3 nearest = svd.matrixU() * svd.matrixV().transpose();
  return {Quat(nearest).normalized(), T.topRightCorner<3, 1>()};
}

Lens lensOf(const std::string& path, const YAML::Node& root) {
  const std::string name =
      root["distortion_model"] ? root["distortion_model"].as<std::string>("") : "";
  if (name == "radial-tangential" || name == "radtan" || name == "plumb_bob") return Lens::radtan;
  if (name == "equidistant" || name == "equi" || name == "kannala_brandt" || name == "fisheye")
    return Lens::equidistant;
  if (name == "none") return Lens::none;
  fail(path, "distortion_model is `" + name +
                 "`; known are radial-tangential (radtan, plumb_bob), equidistant (kannala_brandt) "
                 "and none");
}

double optionalNumber(const std::string& path, const YAML::Node& root, const std::string& key) {
  return root[key] ? number(path, key, root[key]) : 0.0;
}

}  // namespace

CameraYaml readCameraYaml(const std::string& path) {
  const YAML::Node root = load(path);
  CameraYaml c;
  const auto size = numbers(path, root, "resolution");
  const bool whole =
      size.size() == 2 && size[0] == std::floor(size[0]) && size[1] == std::floor(size[1]);
  if (!whole || size[0] < 8 || size[1] < 8 || size[0] > 20000 || size[1] > 20000) {
    fail(path, "`resolution` must be [width, height] in pixels, each between 8 and 20000");
  }
  c.width = static_cast<int>(size[0]);
  c.height = static_cast<int>(size[1]);
  if (root["camera_model"] && root["camera_model"].as<std::string>("") != "pinhole") {
    fail(path, "camera_model is `" + root["camera_model"].as<std::string>("") +
                   "`; only pinhole is known");
  }
  const auto k = numbers(path, root, "intrinsics");
  if (k.size() != 4) fail(path, "`intrinsics` must be [fx, fy, cx, cy]");
  c.fx = k[0], c.fy = k[1], c.cx = k[2], c.cy = k[3];
  if (c.fx <= 0 || c.fy <= 0) fail(path, "`intrinsics`: focal lengths must be positive");
  if (c.cx < 0 || c.cx > c.width || c.cy < 0 || c.cy > c.height) {
    fail(path, "`intrinsics`: the principal point lies outside the image");
  }
  c.lens = lensOf(path, root);
  if (c.lens != Lens::none) {
    const auto d = numbers(path, root, "distortion_coefficients");
    const std::size_t most = c.lens == Lens::radtan ? 5 : 4;
    if (d.size() < 4 || d.size() > most) {
      fail(path, "`distortion_coefficients` has " + std::to_string(d.size()) +
                     " numbers; this model takes 4" + (most == 5 ? " or 5" : ""));
    }
    std::copy(d.begin(), d.end(), c.dist.begin());
  }
  c.T_B_C = poseOf(path, root, true);
  return c;
}

ImuYaml readImuYaml(const std::string& path, ProblemLog* log) {
  const YAML::Node root = load(path);
  ImuYaml imu;
  imu.T_B_I = poseOf(path, root, false);
  imu.gyro_noise_density = optionalNumber(path, root, "gyroscope_noise_density");
  imu.gyro_random_walk = optionalNumber(path, root, "gyroscope_random_walk");
  imu.acc_noise_density = optionalNumber(path, root, "accelerometer_noise_density");
  imu.acc_random_walk = optionalNumber(path, root, "accelerometer_random_walk");
  imu.has_noise = imu.gyro_noise_density > 0 && imu.gyro_random_walk > 0 &&
                  imu.acc_noise_density > 0 && imu.acc_random_walk > 0;
  if (!imu.has_noise) {
    log->note(
        path +
        ": not all four noise densities are given and positive; none is passed on, the estimator's "
        "defaults hold");
  }
  return imu;
}

UwbYaml readUwbYaml(const std::string& path) {
  const YAML::Node root = load(path);
  UwbYaml uwb;
  uwb.T_B_U = poseOf(path, root, true);
  if (root["range_noise_sigma"]) {
    uwb.sigma_m = number(path, "range_noise_sigma", root["range_noise_sigma"]);
    if (*uwb.sigma_m <= 0) fail(path, "`range_noise_sigma` must be positive");
  }
  return uwb;
}

Pose readSensorPose(const std::string& path) { return poseOf(path, load(path), false); }

}  // namespace vir::euroc
