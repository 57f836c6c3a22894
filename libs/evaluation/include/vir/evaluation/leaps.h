#pragma once
/// Poses of a reference that cannot be where it says: a marker taken for another, a fix off the
/// Earth, zeros while the tracker saw nothing.
#include "vir/evaluation/trajectory.h"

namespace vir::evaluation {

/// The trajectory without the poses that no robot can have reached: a step is a leap if it is more
/// than 1 m, faster than 100 m/s, and 20 times as fast as the steps around it (their median). The
/// longest piece between leaps is believed, and of the others those that can be reached from what
/// is believed already. Ascending in time; poses that are no numbers are left out too. `left_out`
/// counts; it may be null.
Trajectory withoutLeaps(const Trajectory& trajectory, long* left_out);

/// What was left out, in words for a warning.
std::string describeLeaps(long left_out);

}  // namespace vir::evaluation
