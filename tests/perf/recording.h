#pragma once
/// Reads just enough of an EuRoC folder for the developer tools (the euroc plugin is the real
/// thing).
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "vir/camera/camera_model.h"
#include "vir/core/time.h"
#include "vir/geometry/interpolation.h"
#include "vir/geometry/pose.h"

namespace vir::tool {

struct Gyro {
  TimeNs t;
  Vec3 w;  ///< [rad/s], body frame
};

struct StampedPose {
  TimeNs t;
  Pose T_W_B;
};

struct Recording {
  std::vector<std::pair<TimeNs, std::string>> images;  ///< stamp, file
  std::vector<Gyro> gyro;
  std::vector<StampedPose> truth;
  Pose T_B_C;
  CameraCalibration calibration;

  /// R_C0_C1 between two stamps from the gyro, `bias` [rad/s] taken off.
  Mat3 gyroRotation(TimeNs t0, TimeNs t1, const Vec3& bias) const {
    Quat q = Quat::Identity();
    for (std::size_t i = 0; i + 1 < gyro.size(); ++i) {
      const TimeNs a = std::max(t0, gyro[i].t), b = std::min(t1, gyro[i + 1].t);
      if (a < b) q = q * expQuat((0.5 * (gyro[i].w + gyro[i + 1].w) - bias) * toSeconds(b - a));
    }
    return (T_B_C.q.conjugate() * q * T_B_C.q).toRotationMatrix();
  }
  /// Ground truth, interpolated; false outside of it.
  bool pose(TimeNs t, Pose* T_W_B) const {
    for (std::size_t i = 0; i + 1 < truth.size(); ++i) {
      if (t < truth[i].t || t > truth[i + 1].t) continue;
      const double u = toSeconds(t - truth[i].t) / toSeconds(truth[i + 1].t - truth[i].t);
      *T_W_B = interpolate(truth[i].T_W_B, truth[i + 1].T_W_B, u);
      return true;
    }
    return false;
  }
};

inline std::vector<double> numbers(std::string line) {
  for (char& c : line) {
    if (c == ',' || c == '[' || c == ']') c = ' ';
  }
  std::istringstream in(line);
  std::vector<double> out;
  for (double v; in >> v;) out.push_back(v);
  return out;
}

inline std::ifstream open(const std::string& file) {
  std::ifstream in(file);
  if (!in) throw std::runtime_error("cannot read " + file);
  return in;
}

/// Numbers behind `key:` in a yaml file, over as many lines as the brackets span.
inline std::vector<double> yamlNumbers(const std::string& file, const std::string& key) {
  std::ifstream in = open(file);
  std::stringstream all;
  all << in.rdbuf();
  const std::string text = all.str();
  const std::size_t at = text.find(key + ":");
  if (at == std::string::npos) throw std::runtime_error(file + ": no " + key);
  const std::size_t from = text.find('[', at), to = text.find(']', from);
  return numbers(text.substr(from, to - from));
}

inline TimeNs tumTime(const std::string& word) {
  const std::size_t dot = word.find('.');
  std::string fraction = dot == std::string::npos ? "" : word.substr(dot + 1);
  fraction.resize(9, '0');
  return std::stoll(word.substr(0, dot)) * 1000000000LL + std::stoll(fraction);
}

inline Recording readRecording(const std::string& mav0, const std::string& truth_tum) {
  Recording r;
  std::string line;
  std::ifstream images = open(mav0 + "/cam0/data.csv");
  while (std::getline(images, line)) {
    if (line.empty() || line[0] == '#') continue;
    const std::size_t comma = line.find(',');
    std::string name = line.substr(comma + 1);
    while (!name.empty() && (name.back() == '\r' || name.back() == ' ')) name.pop_back();
    r.images.emplace_back(std::stoll(line), mav0 + "/cam0/data/" + name);
  }
  std::ifstream imu = open(mav0 + "/imu0/data.csv");
  while (std::getline(imu, line)) {
    if (line.empty() || line[0] == '#') continue;
    const auto v = numbers(line.substr(line.find(',') + 1));
    r.gyro.push_back({std::stoll(line), Vec3(v[0], v[1], v[2])});
  }
  if (!truth_tum.empty()) {
    std::ifstream truth = open(truth_tum);
    while (std::getline(truth, line)) {
      if (line.empty() || line[0] == '#') continue;
      const auto v = numbers(line.substr(line.find(' ')));
      r.truth.push_back({tumTime(line.substr(0, line.find(' '))),
                         Pose(Quat(v[6], v[3], v[4], v[5]).normalized(), Vec3(v[0], v[1], v[2]))});
    }
  }
  const std::string yaml = mav0 + "/cam0/sensor.yaml";
  const auto T = yamlNumbers(yaml, "data");
  Mat3 R;
  R << T[0], T[1], T[2], T[4], T[5], T[6], T[8], T[9], T[10];
  r.T_B_C = Pose(Quat(R).normalized(), Vec3(T[3], T[7], T[11]));
  const auto size = yamlNumbers(yaml, "resolution"), f = yamlNumbers(yaml, "intrinsics"),
             d = yamlNumbers(yaml, "distortion_coefficients");
  r.calibration.width = static_cast<int>(size[0]);
  r.calibration.height = static_cast<int>(size[1]);
  r.calibration.fx = f[0];
  r.calibration.fy = f[1];
  r.calibration.cx = f[2];
  r.calibration.cy = f[3];
  std::copy(d.begin(), d.begin() + std::min<std::ptrdiff_t>(5, d.end() - d.begin()),
            r.calibration.dist.begin());
  std::ifstream in = open(yaml);
  std::stringstream all;
  all << in.rdbuf();
  r.calibration.distortion = all.str().find("equidistant") != std::string::npos
                                 ? Distortion::equidistant
                                 : Distortion::radtan;
  return r;
}

}  // namespace vir::tool
