#pragma once
/// A small recording in the EuRoC or TUM-VI layout, written for a test, with faults put in by hand.
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "vir_test_temp_folder.h"

namespace vir::test {

struct EurocFolderOptions {
  int images = 10;
  std::int64_t start_ns = 1403636580000000123;
  std::int64_t image_period_ns = 50'000'000;
  std::int64_t imu_period_ns = 5'000'000;
  int imu_per_image = 10;
  int width = 64, height = 48;
  bool tum_vi = false;  ///< equidistant camera, 16-bit images, ground truth in mocap0
  bool ranges = true;
  bool ground_truth = true;
  std::string line_end = "\n";
};

/// Motion of the ground truth: 1 m/s along x, yawing by 0.5 rad/s; t in seconds from the start.
inline double truthX(double t) { return t; }
inline double truthYaw(double t) { return 0.5 * t; }

class EurocFolder {
 public:
  explicit EurocFolder(const EurocFolderOptions& options = {}) : o(options) {
    writeCamera();
    writeImu();
    if (o.ranges) writeRanges();
    if (o.ground_truth) writeGroundTruth();
  }

  std::filesystem::path root() const { return temp_.path() / "recording"; }
  std::filesystem::path mav0() const { return root() / "mav0"; }
  std::filesystem::path temp() const { return temp_.path(); }
  std::int64_t imageStamp(int i) const { return o.start_ns + i * o.image_period_ns; }
  std::filesystem::path imageFile(int i) const {
    return mav0() / "cam0" / "data" / (std::to_string(imageStamp(i)) + ".png");
  }
  int imuRows() const { return (o.images - 1) * o.imu_per_image + 1; }

  std::string read(const std::string& name) const { return readText(mav0() / name); }
  void write(const std::string& name, const std::string& text) const {
    writeText(mav0() / name, text);
  }
  void append(const std::string& name, const std::string& text) const {
    write(name, read(name) + text);
  }
  /// Replaces the first `from`; throws if it is not there, so that no test tests nothing.
  void replace(const std::string& name, const std::string& from, const std::string& to) const {
    std::string text = read(name);
    const auto at = text.find(from);
    if (at == std::string::npos) throw std::runtime_error(name + " does not hold " + from);
    write(name, text.replace(at, from.size(), to));
  }
  /// The n-th data row (0-based) of a file with one header line, without its line break.
  std::string row(const std::string& name, int n) const {
    std::istringstream in(read(name));
    std::string line;
    for (int i = -1; i <= n; ++i) std::getline(in, line);
    if (!line.empty() && line.back() == '\r') line.pop_back();
    return line;
  }

  static std::string poseYaml(const std::string& data) {
    return "T_BS:\n  cols: 4\n  rows: 4\n  data: [" + data + "]\n";
  }
  static constexpr const char* kIdentity =
      "1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0,\n   0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0";
  /// Camera looking along body x: camera z = body x, camera x = -body y.
  static constexpr const char* kCameraPose =
      "0.0, 0.0, 1.0, 0.1, -1.0, 0.0, 0.0, 0.02,\n   0.0, -1.0, 0.0, 0.03, 0.0, 0.0, 0.0, 1.0";

 private:
  void writeCamera() const {
    const std::string model = o.tum_vi ? "equidistant" : "radial-tangential";
    write("cam0/sensor.yaml",
          "%YAML:1.0\n# comment\nsensor_type: camera\n" + poseYaml(kCameraPose) +
              "rate_hz: 20\nresolution: [" + std::to_string(o.width) + ", " +
              std::to_string(o.height) +
              "]\ncamera_model: pinhole\nintrinsics: [40.5, 41.5, 31.25, 24.75] #fu, fv, cu, cv\n"
              "distortion_model: " +
              model + "\ndistortion_coefficients: [-0.28, 0.07, 0.0002, 1.5e-05]\n");
    std::string list = "#timestamp [ns],filename" + o.line_end;
    std::filesystem::create_directories(mav0() / "cam0" / "data");
    for (int i = 0; i < o.images; ++i) {
      list +=
          std::to_string(imageStamp(i)) + "," + std::to_string(imageStamp(i)) + ".png" + o.line_end;
      cv::imwrite(imageFile(i).string(), picture(i));
    }
    write("cam0/data.csv", list);
  }

  /// Grey value 10 + i, with a ramp so that it is not constant.
  cv::Mat picture(int i) const {
    cv::Mat m(o.height, o.width, o.tum_vi ? CV_16UC1 : CV_8UC1);
    for (int y = 0; y < m.rows; ++y) {
      for (int x = 0; x < m.cols; ++x) {
        const int v = 10 + i + x;
        if (o.tum_vi)
          m.at<std::uint16_t>(y, x) = static_cast<std::uint16_t>(v * 257);
        else
          m.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(v);
      }
    }
    return m;
  }

  void writeImu() const {
    write("imu0/sensor.yaml",
          "sensor_type: imu\n" + poseYaml(kIdentity) +
              "rate_hz: 200\ngyroscope_noise_density: 1.7e-04 # comment\n"
              "gyroscope_random_walk: 1.9e-05\naccelerometer_noise_density: 2.0e-3\n"
              "accelerometer_random_walk: 3.0e-3\n");
    std::string text = "#timestamp [ns],w_RS_S_x [rad s^-1],...,a_RS_S_z [m s^-2]" + o.line_end;
    char line[200];
    for (int i = 0; i < imuRows(); ++i) {
      std::snprintf(line, sizeof line, "%lld,%.6f,0.02,0.03,0.1,0.2,9.81",
                    static_cast<long long>(o.start_ns + i * o.imu_period_ns), 0.001 * i);
      text += line + o.line_end;
    }
    write("imu0/data.csv", text);
  }

  void writeRanges() const {
    write("uwb0/sensor.yaml", "sensor_type: uwb\n" +
                                  poseYaml("1, 0, 0, 0.1, 0, 1, 0, 0.2, 0, 0, 1, 0.3, 0, 0, 0, 1") +
                                  "rate_hz: 20\nrange_noise_sigma: 0.07\n");
    std::string text = "#timestamp [ns],anchor_id,range [m],true_range [m],nlos" + o.line_end;
    char line[200];
    for (int i = 0; i < o.images; ++i) {
      std::snprintf(line, sizeof line, "%lld,%d,%.8f,0,0",
                    static_cast<long long>(imageStamp(i) + 1'234'567), 3, 2.5 + 0.01 * i);
      text += line + o.line_end;
    }
    write("uwb0/data.csv", text);
  }

  void writeGroundTruth() const {
    std::string text =
        "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], "
        "q_RS_z []";
    if (!o.tum_vi) {
      text +=
          ", v_RS_R_x [m s^-1], v_RS_R_y [m s^-1], v_RS_R_z [m s^-1], b_w_RS_S_x [rad s^-1], "
          "b_w_RS_S_y [rad s^-1], b_w_RS_S_z [rad s^-1], b_a_RS_S_x [m s^-2], b_a_RS_S_y [m s^-2], "
          "b_a_RS_S_z [m s^-2]";
    }
    text += o.line_end;
    char line[300];
    for (int i = 0; i < imuRows(); ++i) {
      const double t = 1e-9 * static_cast<double>(i * o.imu_period_ns);
      std::snprintf(line, sizeof line, "%lld,%.9f,0.5,1.5,%.9f,0,0,%.9f",
                    static_cast<long long>(o.start_ns + i * o.imu_period_ns), truthX(t),
                    std::cos(truthYaw(t) / 2), std::sin(truthYaw(t) / 2));
      text += line;
      if (!o.tum_vi) text += ",0,0,0,0,0,0,0,0,0";
      text += o.line_end;
    }
    write(std::string(o.tum_vi ? "mocap0" : "state_groundtruth_estimate0") + "/data.csv", text);
  }

 public:
  const EurocFolderOptions o;

 private:
  TempFolder temp_;
};

}  // namespace vir::test
