#pragma once
/// Pieces of the ini that goes beside a rawlog.
#include <cstdio>
#include <string>

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

/// Section [Camera]: stamp of an image + this = its time on the IMU's clock.
inline std::string cameraSection(double time_offset_s) {
  char text[64];
  std::snprintf(text, sizeof text, "[Camera]\ntime_offset_s = %.9g\n", time_offset_s);
  return text;
}

}  // namespace vir
