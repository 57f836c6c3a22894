#pragma once
/// How good a trajectory is: absolute and relative errors against a reference.
#include <stdexcept>
#include <string>
#include <vector>

#include "vir/evaluation/alignment.h"

namespace vir::evaluation {

/// The comparison cannot be made; what() says why and what to do.
class EvaluationError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Statistics of non-negative errors; all 0 when there are none.
struct Statistics {
  long count = 0;
  double rmse = 0, mean = 0, median = 0, p95 = 0, max = 0;
};

/// Percentiles by linear interpolation between the ordered values.
Statistics statisticsOf(std::vector<double> errors);

struct EvaluationOptions {
  Alignment alignment = Alignment::posyaw;
  AssociationOptions association;
  std::vector<double> distances_m{1, 2, 5, 10, 20};  ///< for RPE, ascending not needed
  double rpe_time_s = 1;
  /// The attitudes of the reference or the estimate mean nothing, whatever they are. The
  /// reference's mean nothing either where they are all the same while it moves and the estimate
  /// turns, or has up elsewhere, by 45 deg.
  bool positions_only = false;
};

/// Relative errors over pieces of one length. A piece starts at every matched pose and ends at the
/// first one that is `length` further on; it is not used when that overshoots by more than a
/// quarter (a hole in the estimate).
struct RelativeError {
  double length = 0;           ///< nominal: [m] of travelled reference path, or [s]
  Statistics translation_m;    ///< of the relative pose's error
  Statistics translation_pct;  ///< of the length actually travelled; empty for pieces of time
  Statistics rotation_deg;
  Statistics yaw_deg;  ///< the part of the rotation error about the vertical
};

struct EvaluationResult {
  Alignment alignment = Alignment::posyaw;
  AlignmentResult transform;
  /// Scale that would lay the estimate's positions onto the reference's best (Umeyama 1991),
  /// whatever the alignment; 0: the positions do not determine it.
  double best_scale = 0;
  /// False: the reference has positions only. Errors of rotation and relative errors are then
  /// empty.
  bool attitudes = true;
  long reference_left_out = 0;                ///< poses where nothing can be (leaps.h)
  Association association;                    ///< pairs hold the estimate as it was, not aligned
  std::vector<Pose> aligned;                  ///< T_R_B of each pair's estimate
  std::vector<double> position_error_m;       ///< per pair
  std::vector<double> orientation_error_deg;  ///< per pair; zeros without attitudes
  Statistics ate_position_m;
  Statistics ate_orientation_deg;
  std::vector<RelativeError> rpe_distance;  ///< one per asked distance, count 0 where too short
  RelativeError rpe_time;
  double path_m = 0;       ///< length of the matched reference path
  double end_error_m = 0;  ///< at the last matched pose, after alignment
  /// Translation error of the last matched pose relative to the first: the drift over the whole
  /// path, heading error at the start included.
  double end_to_start_m = 0;
};

/// Poses of the reference where nothing can be are left out (leaps.h). Throws EvaluationError: a
/// trajectory is empty, the two do not overlap in time, fewer than 3 poses have a reference, or
/// positions are so large that their errors are no numbers.
EvaluationResult evaluate(const Trajectory& reference, const Trajectory& estimate,
                          const EvaluationOptions& options);

/// The reference moved to where the alignment puts the estimate, its scale left as it is.
Trajectory inWorldOfEstimate(const Trajectory& reference, const EvaluationResult& result);

/// How the comparison was made, in words for the head of a table: alignment and association.
std::string describeComparison(const EvaluationOptions& options);

}  // namespace vir::evaluation
