#pragma once
/// Is it the same place, and where is the one keyframe as seen from the other?
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "vir/core/options.h"
#include "vir/geometry/pose.h"
#include "vir/types/loop.h"

namespace vir::places {

struct VerifyOptions {
  double sigma_px = 1.0;          ///< of a corner found again, as a pixel of `focal_px`
  double sigma_px_unknown = 2.0;  ///< the same without any prior: another day, seen from elsewhere
  double focal_px = 0;            ///< pixels per radian; 0: as the newer keyframe's points say
  int max_distance_bits = 64;     ///< of descriptors that are matched
  double ratio = 0.85;            ///< distance of the best to that of the second best
  int max_iterations = 200;       ///< of the random search
  int min_matches = 12;           ///< fewer are not looked at
  int min_inliers = 35;           ///< different corners of the newer keyframe
  int min_inliers_known = 20;     ///< the same where a prior says as well where it must be
  double min_share = 0.3;         ///< inliers of the points that must be in view
  int min_inliers_alone = 20;     ///< a place that nothing else looks like is told of with so many
  double min_share_alone = 0.1;   ///< and this share
  int min_inliers_compared = 12;  ///< the same where the image is compared as well (LoopFinder)
  double min_share_compared = 0.05;
  double sure_share = 0.65;       ///< of so many, `min_inliers_known` are enough
  double min_share_known = 0.15;  ///< the same with such a prior
  double known_sigma_m = 0.5;     ///< a prior that is less certain does not say it
  double min_spread_rad = 0.06;   ///< of the inliers' rays, along the shorter axis
  double max_sigma_m = 0.15;      ///< a pose less certain is no loop
  double max_sigma_rad = 0.03;
  double gravity_sigma_rad = 0.01;  ///< how well roll and pitch of a keyframe are known
  double scale_sigma = 0.03;        ///< of the distances of a keyframe, all together
  double bias_px = 0.7;    ///< lens and distances, all corners together: more corners do not help
  double prior_chi2 = 28;  ///< of six degrees of freedom
  int seed = 1;

  /// Throws std::invalid_argument for a value that is not allowed.
  void validate() const;
};
void describe(OptionVisitor& v, VerifyOptions& o);

/// What is known without images: of (position in the older body [m], rotation on the right [rad]).
struct RelativePrior {
  Pose T_older_newer;  ///< body to body
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Identity();
};

/// Squared distance between a loop and what is known otherwise, in their sigmas: chi-square of six
/// degrees of freedom. Infinite where covariances are none.
double loopChi2(const Loop& loop, const RelativePrior& prior);

/// Less must be found where it is said anyway that this is the place: to `known_sigma_m`.
bool saysWhere(const RelativePrior* prior, const VerifyOptions& options);

enum class LoopRefusal {
  none,
  few_matches,
  no_pose,       ///< no pose explains enough of them
  few_inliers,   ///< of the points in view
  narrow,        ///< all in one corner of the image
  uncertain,     ///< the pose is not well known
  against_prior  ///< odometry and ranges contradict
};
const char* name(LoopRefusal refusal);

struct LoopVerdict {
  std::optional<Loop> loop;  ///< accepted
  /// As found, whether accepted or refused as `against_prior` or for too few corners: a place that
  /// it could be.
  std::optional<Loop> found;
  LoopRefusal refusal = LoopRefusal::none;
  int matches = 0, inliers = 0;
  bool known = false;  ///< a prior says to `known_sigma_m` where the place must be
  double share = 0;    ///< inliers of the points that must be in view
  double chi2 = 0;     ///< against the prior; 0 without one
};

/// `older`: the candidate, then keyframes near it of the same segment (their relative poses are
/// believed). W of the two sides need not be the same, but z is up in both. Points that are not
/// finite are passed over. Deterministic.
LoopVerdict verifyLoop(const PlaceKeyframe& newer,
                       const std::vector<std::shared_ptr<const PlaceKeyframe>>& older,
                       const VerifyOptions& options = {}, const RelativePrior* prior = nullptr);

}  // namespace vir::places
