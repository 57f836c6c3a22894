#pragma once
/// Pieces of the ini that goes beside a rawlog.
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

namespace vir {

/// Section [Imu] of whatever has the four densities (continuous time, SI units).
template <typename Noise>
std::string imuSection(const Noise& n) {
  char text[512];
  std::snprintf(text, sizeof text,
                "[Imu]\n"
                "gyro_noise_density = %.6g  // rad/s/sqrt(Hz)\n"
                "gyro_random_walk = %.6g  // rad/s^2/sqrt(Hz)\n"
                "acc_noise_density = %.6g  // m/s^2/sqrt(Hz)\n"
                "acc_random_walk = %.6g  // m/s^3/sqrt(Hz)\n",
                n.gyro_noise_density, n.gyro_random_walk, n.acc_noise_density, n.acc_random_walk);
  return text;
}

/// Section [Camera]: stamp of an image + this = its time on the IMU's clock, of the first camera
/// and of those beside it. Empty where nothing is known.
inline std::string cameraSection(const std::optional<double>& first_s,
                                 const std::vector<double>& others_s) {
  std::string out;
  char text[64];
  if (first_s) {
    std::snprintf(text, sizeof text, "time_offset_s = %.9g\n", *first_s);
    out += text;
  }
  if (!others_s.empty()) out += "other_time_offsets_s =";
  for (const double offset : others_s) {
    std::snprintf(text, sizeof text, " %.9g", offset);
    out += text;
  }
  if (!others_s.empty()) out += "\n";
  return out.empty() ? out : "[Camera]\n" + out;
}

}  // namespace vir
