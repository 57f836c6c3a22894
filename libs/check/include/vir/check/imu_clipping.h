#pragma once
/// Readings cut off at a limit: at the end of the sensor's range, by a driver, or by a type.
#include <array>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "vir/check/finding.h"
#include "vir/types/imu_sample.h"

namespace vir::check {

/// Memory does not grow with the stream.
class ImuClipping {
 public:
  /// Finite readings, in order of time.
  void add(const ImuSample& sample);
  enum class Sensor { gyro, accelerometer };
  /// `unit`: of its readings.
  std::optional<Finding> finding(Sensor sensor, const std::string& label,
                                 const std::string& unit) const;

 private:
  /// One end of one axis: the farthest number it ever said, and what is known of those near it.
  struct End {
    double limit = 0;             ///< farthest value so far, by magnitude; in the reading's unit
    long at = 0;                  ///< readings that are just this number
    long again = 0;               ///< those of them whose predecessor was, too
    std::map<double, long> near;  ///< how often others near it come, kFollowed of them at most
    std::set<double> passed;      ///< different numbers on the way there, kPassed at most
    bool last_at = false;
    void add(double size);
    long mostNear() const;
    bool clipped() const;
  };
  std::array<std::array<End, 2>, 6> ends_;  ///< gyro x y z, accelerometer x y z; below, above 0
  long count_ = 0;
};

}  // namespace vir::check
