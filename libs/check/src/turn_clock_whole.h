#pragma once
/// Offset and rate of the camera's clock from all turns together.
#include <optional>
#include <vector>

#include "vir/imu/imu_buffer.h"
#include "vir/initialization/image_turn.h"

namespace vir::check {

/// Rates looked for, to both sides.
constexpr double kMostRate = 0.036;

struct WholeClock {
  double offset_s = 0;  ///< at `origin`, to be added to stamps of images
  double rate = 0;      ///< beside that, per second since then
  double rate_sigma = 0;
  Vec3 gyro_bias = Vec3::Zero();  ///< [rad/s]
  double explained = 0;           ///< share of the gyro's variation that the images explain, 0..1
  double against_none = 0;        ///< what is left of the misfit, as a share of that without a rate
};

/// A smooth and slow turning says little in each piece of it, where an offset is as good as a bias;
/// one bias for all of it leaves the rate. Turns in order of time, which may overlap. Nothing where
/// there are too few.
std::optional<WholeClock> fitWhole(const std::vector<initialization::ImageTurn>& turns,
                                   const imu::ImuBuffer& readings, const Mat3& R_B_C,
                                   TimeNs origin);

}  // namespace vir::check
