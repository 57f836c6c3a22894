#pragma once
/// Readings at the end of the sensor's range: the motion went beyond it, and what is integrated is
/// too little.
#include <array>
#include <optional>
#include <string>

#include "vir/types/imu_sample.h"

namespace vir::imu {

class SaturationCounter {
 public:
  /// A stretch is at least kFewest readings in a row in which one axis says the very same number,
  /// the largest that it ever said, while another axis goes on changing. Noise moves every reading
  /// that is not at the end of the range; a sensor that repeats itself repeats all axes. Returns
  /// the stamp with which the stretch began that this reading belongs to, the earliest of several.
  std::optional<TimeNs> add(const ImuSample& s);

  static constexpr int kFewest = 3;

  long readings() const;      ///< in such stretches; of several axes at once each is counted
  double longestS() const;    ///< the longest stretch [s]
  std::string where() const;  ///< e.g. "accelerometer x at 39.2 m/s^2"; empty if there is none

 private:
  /// One end of one axis.
  struct End {
    double limit = 0;  ///< farthest value so far, by magnitude; 0: none that counts
    TimeNs first = 0;  ///< of the run of such values
    int run = 0;
    long readings = 0;
    TimeNs longest = 0;
  };
  /// True in a stretch.
  bool add(End* end, double value, double least, TimeNs t) const;
  const End* worst() const;

  std::array<std::array<End, 2>, 6> ends_;  ///< gyro x y z, accelerometer x y z; below, above 0
  ImuSample last_;
  bool any_ = false;
};

}  // namespace vir::imu
