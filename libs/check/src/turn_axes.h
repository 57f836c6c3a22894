#pragma once
/// Rates of gyro and images, held against each other: the axes, a constant beside them, the scale.
#include <vector>

#include "vir/check/turning_check.h"

namespace vir::check {

/// Rotation (or mirror) from the gyro's axes to the camera's that explains the pairs best, beside a
/// constant of the gyro.
struct AxesFit {
  Mat3 rotation = Mat3::Identity(), mirror = Mat3::Identity();
  double rotation_rest = 1, mirror_rest = 1;  ///< median share of the rate left unexplained
  double second_axis = 0;                     ///< how much turning there is about other axes, 0..1
};

AxesFit fitAxes(const std::vector<TurnPair>& pairs);

/// What the gyro says beside the turning of images with this rotation [rad/s]; zero where a
/// constant cannot be told from turning that goes on and on.
Vec3 biasWith(const std::vector<TurnPair>& pairs, const Mat3& R_C_B);

/// Median share of the rate that this rotation, and a constant, leave unexplained.
double restOf(const std::vector<TurnPair>& pairs, const Mat3& R_C_B);

/// By how much the gyro's rates are larger than those of the images, a constant aside.
double ratioOf(const std::vector<TurnPair>& pairs);

}  // namespace vir::check
