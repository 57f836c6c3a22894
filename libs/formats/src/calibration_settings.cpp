/// A calibration file as settings of a run.
#include <string>

#include "vir/core/ini_writer.h"
#include "vir/formats/calibration_file.h"

namespace vir::formats {
namespace {

class Assignments {
 public:
  void add(const std::string& key, const std::vector<double>& values) {
    std::string text;
    for (const double v : values) text += (text.empty() ? "" : " ") + numberText(v);
    if (!values.empty()) lines.push_back(key + "=" + text);
  }
  void add(const std::string& key, double value) { lines.push_back(key + "=" + numberText(value)); }
  void add(const std::string& key, const std::optional<double>& value) {
    if (value) add(key, *value);
  }
  void add(const std::string& key, const Vec3& v) {
    lines.push_back(key + "=" + numberText(v.x()) + " " + numberText(v.y()) + " " +
                    numberText(v.z()));
  }
  std::vector<std::string> lines;
};

void addCamera(const CalibratedCamera& c, Assignments* to) {
  to->add("Camera.time_offset_s", c.time_offset_s);
  to->add("Window.readout_s", c.readout_s);
  const CameraSigma& s = c.sigma;
  to->add("Window.extrinsics_sigma_m", s.position_m);
  to->add("Window.extrinsics_sigma_rad", s.rotation_rad);
  to->add("Window.time_offset_sigma_s", s.time_offset_s);
  to->add("Window.readout_sigma_s", s.readout_s);
  to->add("Window.focal_sigma", s.focal);
  to->add("Window.aspect_sigma", s.aspect);
  to->add("Window.centre_sigma_px", s.centre_px);
  to->add("Window.distortion_sigma", s.distortion);
}

}  // namespace

std::vector<std::string> settingsOf(const CalibrationFile& file) {
  Assignments out;
  if (file.imu_noise) {
    const imu::ImuNoise& n = *file.imu_noise;
    out.add("Imu.gyro_noise_density", n.gyro_noise_density);
    out.add("Imu.gyro_random_walk", n.gyro_random_walk);
    out.add("Imu.acc_noise_density", n.acc_noise_density);
    out.add("Imu.acc_random_walk", n.acc_random_walk);
  }
  if (file.imu_correction) {
    const ImuCorrection& c = *file.imu_correction;
    out.add("Imu.gyro_gain", c.gyro_gain);
    out.add("Imu.gyro_axes_rad", c.gyro_axes_rad);
    out.add("Imu.acc_gain", c.acc_gain);
    out.add("Window.gyro_gain_sigma", c.gyro_gain_sigma);
    out.add("Window.gyro_axes_sigma_rad", c.gyro_axes_sigma_rad);
    out.add("Window.acc_gain_sigma", c.acc_gain_sigma);
  }
  if (!file.cameras.empty()) addCamera(file.cameras.front(), &out);
  std::vector<std::optional<double>> offsets;
  for (const CalibratedCamera& c : file.cameras) offsets.push_back(c.time_offset_s);
  out.add("Camera.other_time_offsets_s", otherTimeOffsets(offsets));
  return out.lines;
}

std::vector<double> otherTimeOffsets(const std::vector<std::optional<double>>& of_cameras) {
  std::vector<double> out;
  bool known = false;
  if (of_cameras.empty()) return out;
  for (std::size_t k = 1; k < of_cameras.size(); ++k) {
    known = known || of_cameras[k];
    out.push_back(of_cameras[k].value_or(of_cameras[0].value_or(0)));
  }
  return known ? out : std::vector<double>();
}

}  // namespace vir::formats
