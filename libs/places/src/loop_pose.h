#pragma once
/// How well a relative pose of two level frames explains matches, and the search for one.
#include <optional>
#include <vector>

#include "loop_matches.h"

namespace vir::places {

/// 99 % of two degrees of freedom.
constexpr double kInlierChi2 = 9.21;

/// A point of one side with its distance, seen by the other side.
struct Sight {
  const LevelPoint* from = nullptr;
  const LevelPoint* to = nullptr;
  bool forward = true;  ///< from the older into the newer
};

struct SightFit {
  bool usable = false;  ///< in front, and not merely a line along which it could be anywhere
  double chi2 = 0;      ///< of two degrees of freedom
  Vec2 r = Vec2::Zero();
  /// By (shift of the newer's frame in the older's [m], turn on its right [rad]).
  Eigen::Matrix<double, 2, 6> J = Eigen::Matrix<double, 2, 6>::Zero();
};

/// T: newer level frame to older level frame. `sigma_rad`: of a ray.
SightFit fitSight(const Sight& sight, const Mat3& R, const Vec3& t, double sigma_rad,
                  bool with_jacobian);

/// The sights of a match: none, one or two.
std::vector<Sight> sightsOf(const LevelPlaces& places, const PointMatch& match);

/// Which matches a pose explains, by the better known of their sights.
std::vector<PointMatch> explained(const LevelPlaces& places, const std::vector<PointMatch>& matches,
                                  const Pose& T_older_newer, double sigma_rad);

/// What a ray may be off by where the verticals are taken for known [rad].
double searchSigma(const VerifyOptions& options);

/// Pose in the level frames (yaw and position) that explains most matches: from two points and the
/// vertical, seeded. Nothing if none explains four.
std::optional<Pose> searchPose(const LevelPlaces& places, const std::vector<PointMatch>& matches,
                               const VerifyOptions& options);

/// Poses (yaw, then the distances along the rays) with Rz(yaw) d = a f1 - b f2 + o, a and b > 0: at
/// most two.
struct TwoPointPose {
  double yaw = 0, a = 0, b = 0;
};
std::vector<TwoPointPose> solveTwoPoints(const Vec3& d, const Vec3& f1, const Vec3& f2,
                                         const Vec3& o);

}  // namespace vir::places
