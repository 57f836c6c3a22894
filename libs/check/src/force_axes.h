#pragma once
/// Whether the accelerometer has the gyro's axes, by gravity: turned with the gyro it stands still.
#include <vector>

#include "vir/core/time.h"
#include "vir/geometry/so3.h"

namespace vir::check {

/// Means over a short piece of time.
struct ForceAndTurn {
  TimeNs t = 0;
  Vec3 gyro = Vec3::Zero();  ///< [rad/s]
  Vec3 acc = Vec3::Zero();   ///< in any unit
};

struct ForceAxes {
  bool doubtful = false;
  bool wrong = false;  ///< beyond doubt
  double as_is = 0;    ///< share of the force that averages out within a stretch of 4 s
  double best = 0;     ///< the same with the axes that suit best
};

/// `parts` a quarter of a second each, in order of time. Not wrong where there is too little
/// turning to tell. A negated accelerometer is as good as the right one here.
ForceAxes forceAxes(const std::vector<ForceAndTurn>& parts);

}  // namespace vir::check
