#pragma once
/// Which poses are compared: the reference interpolated at the stamps of the estimate, or, where
/// the reference is the sparser of the two, the estimate at those of the reference.
#include <vector>

#include "vir/evaluation/trajectory.h"

namespace vir::evaluation {

struct AssociationOptions {
  /// The denser of the two is not interpolated across more than this; exact stamps always count.
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
  std::vector<PosePair> pairs;         ///< in time order
  bool estimate_interpolated = false;  ///< at the reference's stamps: it is the denser one
  // Poses at whose stamps the other is wanted, and is not there: of the estimate, or with
  // estimate_interpolated of the reference.
  long before = 0;         ///< the other begins later
  long after = 0;          ///< the other has ended
  long in_gap = 0;         ///< the other has a gap
  double reference_s = 0;  ///< from the first to the last pose of the reference
  double covered_s = 0;    ///< time between matches, holes left out
  /// Share of the reference's duration that is covered, 0..1 (a reference of one pose: 1 if it is
  /// matched).
  double coverage = 0;
};

/// Never extrapolates. Both trajectories ascending in time; either may be empty.
Association associate(const Trajectory& reference, const Trajectory& estimate,
                      const AssociationOptions& options);

}  // namespace vir::evaluation
