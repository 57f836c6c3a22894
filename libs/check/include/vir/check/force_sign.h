#pragma once
/// Whether the accelerometer pushes the camera the way the images move: what tells a negated
/// accelerometer from a camera mounted upside down, and mirrored images from a camera that is
/// given looking back. Gravity alone cannot.
#include <vector>

#include "vir/check/turning.h"
#include "vir/types/imu_sample.h"

namespace vir::check {

struct ForceSign {
  int with = 0;     ///< stretches of time in which points lie in front of the camera
  int against = 0;  ///< those in which they would lie behind it
  /// +1: as it must be; -1: all that is seen lies behind the camera; 0: too little to tell.
  int sign() const;
};

/// In stretches of 1.5 s the velocity and gravity that fit the epipolar lines best follow from the
/// force, linearly [Dong-Si and Mourikis 2012, solved for directions]; with the force the other way
/// round the same lines are fitted by the negative of all, and depths become negative.
/// `turns` in order of time, with their matches; `time_offset_s`: stamp of an image + this = IMU's
/// clock; the unit of the force does not matter, the gyro's is rad/s.
ForceSign forceSign(const std::vector<ImageTurn>& turns, const std::vector<ImuSample>& samples,
                    const Mat3& R_B_C, double time_offset_s);

}  // namespace vir::check
