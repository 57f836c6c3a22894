#pragma once
/// Covariance where the cost is no parabola.
#include "evidence_cost.h"

namespace vir::team {

/// Of a direction that the evidence leaves open [m^2, rad^2].
constexpr double kUnknownVariance = 1e4;

/// Inverse of the Gauss-Newton information; directions left open get kUnknownVariance.
Mat4 gaussNewtonCovariance(const EvidenceCost& cost, const Vec4& x);

/// A Gauss-Newton covariance `C` knows nothing of valleys that bend, nor of a height that enters by
/// its square only (motion in a plane). From the minimum `x`, each coordinate is moved away step by
/// step while the others follow to their minimum; the second moments of these four walks, weighted
/// by the likelihood, widen `C` where they are larger and narrow it where the walk's own coordinate
/// is better known. The yaw turns about `middle_B`; `lever` [m] says what a radian is worth.
Mat4 exploredCovariance(const EvidenceCost& cost, const Vec4& x, const Mat4& C,
                        const Vec3& middle_B, double lever);

/// Mean of the likelihood along the height, the other coordinates following, and its variance: the
/// best that can be said of a height that enters by its square only (motion in a plane), where the
/// likelihood has two equal ends.
struct HeightMean {
  Vec4 x = Vec4::Zero();
  double variance = 0;
};
/// `sigma` [m]: how far the height is open, roughly.
HeightMean heightMean(const EvidenceCost& cost, const Vec4& x, double sigma);

}  // namespace vir::team
