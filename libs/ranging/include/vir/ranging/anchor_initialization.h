#pragma once
/// Where is an anchor of unknown position? From antenna positions and ranges, any time in a
/// mission.
#include <Eigen/Core>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "vir/geometry/pose.h"
#include "vir/ranging/robust_range.h"

namespace vir::ranging {

/// A range and where the antenna was in W at its time. In order of time.
struct AntennaRange {
  Vec3 p_W = Vec3::Zero();
  double range_m = 0;
  double sigma_m = 0.1;  ///< of the range alone
};

/// What is known of the anchor beforehand, e.g. because the robot dropped it.
struct AnchorPrior {
  Vec3 p_W = Vec3::Zero();
  Mat3 covariance = Mat3::Identity();  ///< [m^2]
};

enum class AnchorGeometry {
  good,           ///< one solution, well enough known to be used
  mirror,         ///< two, mirrored at the plane of motion
  too_short,      ///< too few ranges or too little motion for the distance
  straight_line,  ///< motion on a line: a ring of positions fits
  poor,           ///< enough motion, but a direction stays too uncertain
  inconsistent,   ///< no fixed position fits: the anchor moves, or the path or the id is wrong
};
const char* name(AnchorGeometry geometry);

struct AnchorSolution {
  Vec3 p_W = Vec3::Zero();
  double bias_m = 0;                                         ///< constant offset of the ranges
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Identity();  ///< position in W, bias [m^2]
  double cost = 0;  ///< robust loss in units of the ranges' effective variance; differences count
};

struct AnchorInitialization {
  AnchorGeometry geometry = AnchorGeometry::too_short;
  std::string advice;  ///< what would help, e.g. "move sideways: ..."; empty if nothing is amiss
  /// Best first. `good`: one; `mirror`: two that the data cannot tell apart. Otherwise at most two,
  /// for information only; may be empty.
  std::vector<AnchorSolution> solutions;
  /// `max_sigma_m` that these solutions would just pass; infinite without a solution [m].
  double needed_sigma_m = std::numeric_limits<double>::infinity();
  /// What the solutions rest on besides where motion on a floor would else leave the position poor:
  /// a height within `floor_sigma_m` of the floor. Empty otherwise, and with a prior.
  std::optional<AnchorPrior> floor;
  int used = 0;                ///< ranges the solution rests on
  int outliers = 0;            ///< valid ranges that do not fit
  int ignored = 0;             ///< not finite, not positive, without a sigma
  double rms_ratio = 1;        ///< robust rms of the residuals over the claimed sigma
  double variance_factor = 1;  ///< what correlation and rms made the variances grow by, in all
};

struct AnchorInitOptions {
  int min_ranges = 20;        ///< without a prior
  double min_extent_m = 0.3;  ///< of the path along its main direction, without a prior
  double bias_sigma_m = 0.1;  ///< of the constant bias, mean 0; 0: no bias is estimated
  double drift_ratio = 0.01;  ///< growth of the path's error from its end, metre per metre
  double scale_sigma = 0.02;  ///< of the path's length: what comes straight at an anchor looks
                              ///< alike for a scale and for a distance beside the path; 0: none
  double max_sigma_m = 0.5;   ///< the second-largest axis of the position's ellipsoid may be so
                              ///< long; the largest as long as the curvature of the range allows
  double floor_sigma_m = 5;   ///< height of an anchor against a level path, mean 0, where ranges,
                              ///< which tell it by its square only, do not; 0: not assumed
  double mirror_chi2 = 12;    ///< a second solution worse by more than this is rejected
  double max_rms_ratio = 6;   ///< residuals above so many claimed sigmas do not fit one position
  double min_inlier_share = 0.5;
  double max_short_share = 0.1;  ///< outliers that are too short: no obstacle explains them
  bool correlation = true;       ///< let the ranges' autocorrelation widen the covariance
  RobustRange robust;
};

/// Closed form from squared ranges in the principal axes of the path (so that motion in a plane or
/// on a line is no special case), refinement from several starts, second solutions kept while the
/// data allow them. Takes ranges and path as they are; costs a few ms for some hundred ranges and
/// grows linearly. Results are finite for any input. Deterministic. Throws std::invalid_argument
/// for a prior that is not finite or whose covariance is not positive definite.
AnchorInitialization initializeAnchor(const std::vector<AntennaRange>& ranges,
                                      const AnchorInitOptions& options,
                                      const std::optional<AnchorPrior>& prior = std::nullopt);

}  // namespace vir::ranging
