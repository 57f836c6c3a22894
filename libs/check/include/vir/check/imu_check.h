#pragma once
/// Units, columns and noise of an IMU, by itself.
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "vir/check/finding.h"
#include "vir/check/force_sign.h"
#include "vir/check/imu_clipping.h"
#include "vir/check/imu_copies.h"
#include "vir/core/thinned_out.h"
#include "vir/imu/preintegration.h"
#include "vir/types/imu_sample.h"

namespace vir::check {

/// What is needed to think about which way is up.
struct Mounting {
  Mat3 R_B_C = Mat3::Identity();  ///< camera in the body, as given or as found
  std::string camera;             ///< its label
  ForceSign force;                ///< by the images
  bool as_given = true;           ///< false: found by the images, which is a finding already
};

/// Memory: four entries a second of what is kept of the stream.
class ImuCheck {
 public:
  enum class Keeps {
    all,
    evenly,  ///< beyond half an hour stretches of 16 s, rarer as the stream grows: for live use
  };
  explicit ImuCheck(std::string label, Keeps keeps = Keeps::all)
      : label_(std::move(label)), blocks_(keeps == Keeps::all ? kAll : kHalfOfMost, kTogether) {}
  void add(const ImuSample& sample);

  /// Whether it moves between two times of its clock, shaking aside; nothing where it says too
  /// little of that time.
  std::optional<bool> moves(TimeNs from, TimeNs to) const;
  /// |a| at rest, or in the quietest moments there are [m/s^2, if that is its unit]; 0: too short.
  double restMagnitude() const;
  /// Whether readings are there more than once, which is to be known even where stamps are wrong.
  std::optional<Finding> copies() const { return copies_.finding(label_); }
  /// Whether it hangs for a while.
  std::optional<Finding> stuck() const { return copies_.stuck(label_); }
  /// `given`: the densities an estimator would use. `mounting`: where there is a camera.
  /// `gyro_trusted`: nothing else has been found against it. `gyro_bias`: as found [rad/s].
  std::vector<Finding> findings(const std::optional<imu::ImuNoise>& given,
                                const std::optional<Mounting>& mounting, bool gyro_trusted = true,
                                const Vec3& gyro_bias = Vec3::Zero()) const;

 private:
  /// A quarter of a second.
  struct Block {
    TimeNs t = 0;                                  ///< of its first reading
    Vec3 acc = Vec3::Zero(), gyro = Vec3::Zero();  ///< means
    double acc_spread = 0;                         ///< rms distance from the mean
    double acc_step2 = 0, gyro_step2 = 0;  ///< mean squared difference of neighbours, per axis
    double dt = 0;                         ///< mean time between readings [s]
  };
  void close();
  void leaveOutSpikes();
  std::vector<Block> quietest() const;
  bool columnsSwapped(std::vector<Finding>* out) const;
  void checkGravity(std::vector<Finding>* out) const;
  void checkAccelerometer(std::vector<Finding>* out) const;
  void checkGyro(std::vector<Finding>* out) const;
  void checkRates(std::vector<Finding>* out) const;
  bool forceAxesWrong(const Vec3& gyro_bias, std::vector<Finding>* out) const;
  void checkUp(const Mounting& mounting, std::vector<Finding>* out) const;
  void noteNoise(const std::optional<imu::ImuNoise>& given, std::vector<Finding>* out) const;

  static constexpr std::size_t kAll = SIZE_MAX / 4, kHalfOfMost = 3600 / 64 * 64, kTogether = 64;

  const std::vector<Block>& blocks() const { return blocks_.values(); }

  std::string label_;
  ThinnedOut<Block> blocks_;
  ImuClipping clipping_;
  ImuCopies copies_;
  std::vector<ImuSample> open_;  ///< of the block that is being filled
  long not_finite_ = 0, count_ = 0, spikes_ = 0;
  double highest_spike_ = 0;  ///< distance from its neighbours, in its unit
};

}  // namespace vir::check
