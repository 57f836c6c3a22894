#pragma once
/// Which transform between two robots' worlds do their mutual ranges speak for?
#include <optional>
#include <string>
#include <vector>

#include "vir/core/options.h"
#include "vir/ranging/robust_range.h"
#include "vir/team/world_transform.h"

namespace vir::team {

enum class TransformStatus {
  unique,        ///< one transform, well enough known to be used, but for its height where that is
                 ///< open
  ambiguous,     ///< two or more that the evidence cannot tell apart yet
  degenerate,    ///< too little evidence, or a geometry that leaves the transform open
  inconsistent,  ///< no transform explains the ranges: outliers, a wrong peer, a wrong anchor
};
/// "unique", "ambiguous", ...
const char* name(TransformStatus status);

struct TransformSolution {
  WorldTransform T_A_B;
  /// Where the height is the mean of two: the likelier one, by which the ranges are explained.
  std::optional<double> likelier_z_m;
  /// Of (yaw, x, y, z) [rad, m]. A direction that is left open has a variance of 1e4.
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Identity();
  double cost = 0;             ///< -2 log likelihood less a constant; differences count
  int used = 0, rejected = 0;  ///< ranges
  int too_short = 0;           ///< of the rejected: no obstacle explains these
  int anchors_used = 0;        ///< the others contradict the ranges
  int places_used = 0;         ///< seen by both; 0 also where they only look alike
};

struct TransformAnswer {
  TransformStatus status = TransformStatus::degenerate;
  std::string reason;  ///< why it is not unique, and what would help; empty if it is
  /// Best first. `unique`: one; `ambiguous`: those that are not ruled out, one only where two
  /// nearly coincide; else for information only.
  std::vector<TransformSolution> solutions;
  int ranges = 0;   ///< that could be used at all
  int ignored = 0;  ///< not finite, not positive, without a sigma
  int places = 0;   ///< that both robots' images show
  /// Cost of the best other solution less that of the best; infinite if there is no other.
  double margin = 0;
  double needed_margin = 0;    ///< what is asked for by `false_alarm`
  double variance_factor = 1;  ///< what the residuals' own scatter made all variances grow by
  /// The height is left open, as by robots that stay in planes: solutions that differ in it alone
  /// are one, at their mean, and its variance spans them. The status is about yaw, x and y then.
  bool height_open = false;
};

struct TransformOptions {
  double false_alarm = 1e-4;  ///< rate at which a wrong solution may be called unique
  int min_ranges_without_anchor = 6;
  double max_yaw_sigma_rad = 0.12;
  double max_sigma_m = 0.8;          ///< horizontal, of B's path in A's world
  double same_solution_m = 0.5;      ///< solutions that place B's path closer than this are one
  double slow_share = 0.7;           ///< a range's slow error as a share of its sigma
  double slow_time_s = 2.0;          ///< time in which that error changes
  double position_time_s = 30.0;     ///< time in which the errors of positions change
  double drift_m_per_sqrt_s = 0.01;  ///< how the worlds slide against each other beside what the
                                     ///< covariances say; makes recent ranges count more
  double drift_rad_per_sqrt_s = 0.001;
  double gate_sigma = 4;  ///< a range farther off is counted as rejected
  double min_inlier_share = 0.5;
  double max_short_share = 0.1;  ///< outliers that are too short: no obstacle explains them
  double anchor_chi2 = 30;       ///< an anchor that is farther off is taken as wrong
  double places_chi2 = 30;       ///< places that are farther off are taken as such that look alike
  int max_search_ranges = 80;    ///< of all ranges, for finding where to start
  int max_global_evaluations = 3000;
  int polish_evaluations = 40;
  int max_polish_ranges = 200;  ///< with more, what it gains is not worth its time
  ranging::RobustRange robust;

  /// Throws std::invalid_argument for a value that is not allowed.
  void validate() const;
};
/// Section [Rendezvous].
void describe(OptionVisitor& v, TransformOptions& o);

/// Closed form with a common anchor, scan over the yaw with linear trilateration without one,
/// global search (NLopt's DIRECT) where these give nothing to start from; Levenberg-Marquardt, and
/// NLopt's BOBYQA on the full robust cost in the end. Ranges in order of time. Results are finite
/// for any input. Deterministic. Throws as TransformOptions::validate().
///
/// `unique` is a likelihood-ratio test: the best solution must be 1/false_alarm times as likely as
/// any other. This bounds the rate of wrong decisions even when the question is asked again after
/// every range, as long as the error model holds; errors that stay (of ranges and of positions) are
/// part of the model. `hints` are further solutions to start from, e.g. those found before.
/// `places`: what both have seen is evidence as the rest is; no range is needed then.
TransformAnswer findTransform(const std::vector<MutualRange>& ranges,
                              const std::vector<SharedAnchor>& anchors,
                              const TransformOptions& options,
                              const std::vector<WorldTransform>& hints = {},
                              const std::optional<SharedPlaces>& places = {});

}  // namespace vir::team
