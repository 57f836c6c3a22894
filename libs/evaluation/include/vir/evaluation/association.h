#pragma once
/// Which poses are compared: the reference interpolated at the stamps of the estimate.
#include <vector>

#include "vir/evaluation/trajectory.h"

namespace vir::evaluation {

struct AssociationOptions {
  /// The reference is not interpolated across more than this; exact stamps always count.
  TimeNs max_gap = 100000000;
  /// Two neighbouring matches farther apart than this leave a hole in the coverage.
  TimeNs max_hole = 500000000;
};

struct PosePair {
  TimeNs t = 0;
  Pose reference;  ///< T_R_B, R = world of the reference
  Pose estimate;   ///< T_E_B, E = world of the estimate
};

struct Association {
  std::vector<PosePair> pairs;  ///< in time order
  long before = 0;              ///< poses of the estimate before the reference begins
  long after = 0;               ///< poses of the estimate after the reference ends
  long in_gap = 0;              ///< poses of the estimate in a gap of the reference
  double reference_s = 0;       ///< from the first to the last pose of the reference
  double covered_s = 0;         ///< time between matches, holes left out
  /// Share of the reference's duration that is covered, 0..1 (a reference of one pose: 1 if it is
  /// matched).
  double coverage = 0;
};

/// Never extrapolates. Both trajectories ascending in time; either may be empty.
Association associate(const Trajectory& reference, const Trajectory& estimate,
                      const AssociationOptions& options);

}  // namespace vir::evaluation
