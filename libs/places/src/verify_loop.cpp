#include "vir/places/verify_loop.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "loop_refinement.h"
#include "vir/core/order_statistics.h"
#include "vir/geometry/finite_pose.h"

namespace vir::places {
namespace {

using Mat6 = Eigen::Matrix<double, 6, 6>;

constexpr int kRounds = 3;  // of matching by the pose and refining it

/// Spread of the rays of the newer keyframe across its line of sight, along the shorter axis [rad].
double spread(const LevelPlaces& places, const std::vector<PointMatch>& matches) {
  Vec3 mean = Vec3::Zero();
  for (const PointMatch& m : matches) mean += places.newer[m.newer].ray;
  mean /= static_cast<double>(matches.size());
  Mat3 C = Mat3::Zero();
  for (const PointMatch& m : matches) {
    const Vec3 d = places.newer[m.newer].ray - mean;
    C += d * d.transpose();
  }
  C /= static_cast<double>(matches.size());
  const Vec3 axis = mean.normalized();
  const Mat3 across = Mat3::Identity() - axis * axis.transpose();
  const Vec3 values = Eigen::SelfAdjointEigenSolver<Mat3>(across * C * across).eigenvalues();
  return std::sqrt(std::max(values(1), 0.0));  // the least is that along the axis
}

/// What is the same for all corners and so does not average out: the scale of the distances moves
/// the way between the two, the lens and the points' distances the pose.
void addBias(const VerifyOptions& o, const Vec3& way, double distance_m, Mat6* covariance) {
  covariance->topLeftCorner<3, 3>() += o.scale_sigma * o.scale_sigma * way * way.transpose();
  const double turn = o.bias_px / o.focal_px;
  covariance->diagonal().head<3>().array() += turn * turn * distance_m * distance_m;
  covariance->diagonal().tail<3>().array() += turn * turn;
}

/// Median distance of the points that a pose is made from [m].
double medianDistance(const LevelPlaces& places, const std::vector<PointMatch>& matches) {
  std::vector<double> all;
  for (const PointMatch& m : matches) {
    const LevelPoint &a = places.older[m.frame][m.older], &b = places.newer[m.newer];
    const LevelPoint& p = a.known() ? a : b;
    if (p.known()) all.push_back(1 / p.rho);
  }
  return medianInPlace(&all);
}

Loop loopOf(const PlaceKeyframe& newer, const PlaceKeyframe& older, const RefinedPose& refined,
            double distance_m, const VerifyOptions& o) {
  Loop loop;
  loop.older = older.id;
  loop.newer = newer.id;
  const Quat R_L_old = older.T_W_B.q, R_Q_new = newer.T_W_B.q;
  const Pose& T = refined.T_older_newer;
  loop.T_older_newer = {(R_L_old.conjugate() * T.q * R_Q_new).normalized(),
                        R_L_old.conjugate() * T.p};
  Mat6 turn = Mat6::Zero();
  turn.topLeftCorner<3, 3>() = R_L_old.conjugate().toRotationMatrix();
  turn.bottomRightCorner<3, 3>() = R_Q_new.conjugate().toRotationMatrix();
  loop.covariance = turn * refined.covariance * turn.transpose();
  addBias(o, loop.T_older_newer.p, distance_m, &loop.covariance);
  return loop;
}

struct Found {
  RefinedPose pose;
  std::vector<PointMatch> inliers;
  double share = 0;  ///< of the points that must be in view of the other side
};

/// From a first pose to all matches that it leads to, and the pose that these give.
Found refineAndMatch(const LevelPlaces& places, const std::vector<PointMatch>& matches,
                     const Pose& start, const VerifyOptions& options) {
  const double sigma_rad = options.sigma_px / options.focal_px;
  Found out;
  const auto first = explained(places, matches, start, searchSigma(options));
  out.pose = refinePose(places, first, start, options);
  GuidedMatches guided;
  for (int round = 0; round < kRounds && out.pose.valid; ++round) {
    guided = matchGuided(places, out.pose.T_older_newer, options);
    const auto fit = explained(places, guided.matches, out.pose.T_older_newer, sigma_rad);
    out.pose = refinePose(places, fit, out.pose.T_older_newer, options);
  }
  if (!out.pose.valid) return out;
  out.inliers = explained(places, guided.matches, out.pose.T_older_newer, sigma_rad);
  int seen = 0;
  for (const PointMatch& m : out.inliers) {
    if (m.frame != 0) continue;
    // Looked for from either side whose distance is known.
    seen += places.older[0][m.older].known();
    seen += places.newer[m.newer].known();
  }
  out.share = guided.in_view > 0 ? static_cast<double>(seen) / guided.in_view : 0;
  return out;
}

double largestSigma(const Mat3& block) {
  return std::sqrt(Eigen::SelfAdjointEigenSolver<Mat3>(block).eigenvalues()(2));
}

bool uncertain(const Mat6& C, const VerifyOptions& o) {
  return !(largestSigma(C.topLeftCorner<3, 3>()) <= o.max_sigma_m) ||
         !(largestSigma(C.bottomRightCorner<3, 3>()) <= o.max_sigma_rad);
}

/// Many corners, or nearly all of the few that there are; less where a prior says that this is the
/// place.
bool enough(const LoopVerdict& v, const VerifyOptions& o) {
  if (v.inliers < o.min_inliers_known || v.share < o.min_share_known) return false;
  return v.known || (v.inliers >= o.min_inliers && v.share >= o.min_share) ||
         v.share >= o.sure_share;
}

/// Pixels per radian, by pairs of points all over the image: the lowest tenth, since the rim of a
/// wide lens is drawn out.
double focalOf(const PlaceKeyframe& k) {
  constexpr double kNone = 450;
  const std::size_t half = k.points.size() / 2;
  std::vector<double> all;
  for (std::size_t i = 0; i + half < k.points.size(); ++i) {
    const PlacePoint &a = k.points[i], &b = k.points[i + half];
    const double turn = std::acos(std::clamp(
        a.ray_C.cast<double>().normalized().dot(b.ray_C.cast<double>().normalized()), -1.0, 1.0));
    const double way = (a.px - b.px).norm();
    if (turn > 0.05 && way > 0 && std::isfinite(way / turn)) all.push_back(way / turn);
  }
  return all.empty() ? kNone : quantileInPlace(&all, 0.1);
}

bool hasPose(const PlaceKeyframe& k) { return isFinite(k.T_W_B) && isFinite(k.T_B_C); }

}  // namespace

const char* name(LoopRefusal refusal) {
  switch (refusal) {
    case LoopRefusal::none:
      return "none";
    case LoopRefusal::few_matches:
      return "few matches";
    case LoopRefusal::no_pose:
      return "no pose";
    case LoopRefusal::few_inliers:
      return "few inliers";
    case LoopRefusal::narrow:
      return "narrow";
    case LoopRefusal::uncertain:
      return "uncertain";
    case LoopRefusal::against_prior:
      return "against odometry and ranges";
  }
  return "none";
}

bool saysWhere(const RelativePrior* prior, const VerifyOptions& o) {
  return prior && prior->covariance.allFinite() &&
         largestSigma(prior->covariance.topLeftCorner<3, 3>()) <= o.known_sigma_m;
}

double loopChi2(const Loop& loop, const RelativePrior& prior) {
  Eigen::Matrix<double, 6, 1> e;
  e << loop.T_older_newer.p - prior.T_older_newer.p,
      logQuat(prior.T_older_newer.q.conjugate() * loop.T_older_newer.q);
  const Eigen::LDLT<Mat6> ldlt(loop.covariance + prior.covariance);
  if (!e.allFinite() || !(ldlt.vectorD().minCoeff() > 0)) {
    return std::numeric_limits<double>::infinity();
  }
  return e.dot(ldlt.solve(e));
}

LoopVerdict verifyLoop(const PlaceKeyframe& newer,
                       const std::vector<std::shared_ptr<const PlaceKeyframe>>& older,
                       const VerifyOptions& given, const RelativePrior* prior) {
  given.validate();
  VerifyOptions options = given;
  if (!(options.focal_px > 0)) options.focal_px = focalOf(newer);
  if (!prior) options.sigma_px = std::max(options.sigma_px, options.sigma_px_unknown);
  LoopVerdict verdict;
  const auto refuse = [&](LoopRefusal why) {
    verdict.refusal = why;
    return verdict;
  };
  if (older.empty() || !older.front() || !hasPose(newer) || !hasPose(*older.front())) {
    return refuse(LoopRefusal::few_matches);
  }
  const LevelPlaces places = levelPlaces(newer, older);
  const std::vector<PointMatch> matches = matchDescriptors(places, options);
  verdict.matches = countNewer(matches);
  if (verdict.matches < options.min_matches) return refuse(LoopRefusal::few_matches);
  const std::optional<Pose> start = searchPose(places, matches, options);
  if (!start) return refuse(LoopRefusal::no_pose);

  const Found found = refineAndMatch(places, matches, *start, options);
  if (!found.pose.valid) return refuse(LoopRefusal::no_pose);
  verdict.inliers = countNewer(found.inliers);
  verdict.share = found.share;
  verdict.known = saysWhere(prior, options);
  const int fewest = std::min(
      {options.min_inliers_alone, options.min_inliers_known, options.min_inliers_compared});
  const double least =
      std::min({options.min_share_alone, options.min_share_known, options.min_share_compared});
  if (verdict.inliers < fewest || verdict.share < least) return refuse(LoopRefusal::few_inliers);
  if (spread(places, found.inliers) < options.min_spread_rad) return refuse(LoopRefusal::narrow);
  Loop loop =
      loopOf(newer, *older.front(), found.pose, medianDistance(places, found.inliers), options);
  loop.matches = verdict.matches;
  loop.inliers = verdict.inliers;
  if (!loop.covariance.allFinite() || uncertain(loop.covariance, options)) {
    return refuse(LoopRefusal::uncertain);
  }
  verdict.found = loop;
  if (prior) verdict.chi2 = loopChi2(loop, *prior);
  if (prior && !(verdict.chi2 <= options.prior_chi2)) return refuse(LoopRefusal::against_prior);
  if (!enough(verdict, options)) return refuse(LoopRefusal::few_inliers);
  verdict.loop = loop;
  return verdict;
}

}  // namespace vir::places
