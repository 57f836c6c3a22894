#include "explored_covariance.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "vir/core/angles.h"

namespace vir::team {
namespace {

constexpr double kFarthest = 50;     // [m] of a walk
constexpr double kMostRise = 10;     // what is less likely adds nothing
constexpr double kFirstStep = 0.05;  // [m]
constexpr double kGrowth = 0.6;      // of the way so far, a step
constexpr int kIterations = 12;
constexpr int kMostSteps = 200;  // each is 1.6 times the last, from a picometre to the farthest

/// Second moments about `x` along one walk out and one back.
Mat4 momentsOf(const EvidenceCost& cost, const Vec4& x, int coordinate, double sigma,
               const Vec3& middle_B, double lever) {
  const Vec4 axis = Vec4::Unit(coordinate);
  const double unit = coordinate == 0 ? 1 / lever : 1;
  const double limit = coordinate == 0 ? kPi : kFarthest;
  const double first = std::min(0.3 * sigma, kFirstStep * unit);
  if (!(first > 0)) return Mat4::Zero();  // numbers beyond what can be solved for
  const double here = cost(x);
  Mat4 sum = Mat4::Zero();
  double weights = first;
  for (const double sign : {-1.0, 1.0}) {
    Vec4 moved = x;
    double shift = 0;
    for (int i = 0; i < kMostSteps && shift < limit; ++i) {
      const double step = std::max(first, kGrowth * shift);
      shift += step;
      if (coordinate == 0) {
        moved.tail<3>() += rotZ(moved[0]) * middle_B - rotZ(moved[0] + sign * step) * middle_B;
      }
      moved[coordinate] += sign * step;
      const double rise = descend(cost, &moved, {kIterations, 1e-3, &axis}) - here;
      const double weight = step * std::exp(-0.5 * std::clamp(rise, 0.0, 100.0));
      const Vec4 d = moved - x;
      sum += weight * d * d.transpose();
      weights += weight;
      if (rise > kMostRise) break;
    }
  }
  return sum / weights;
}

}  // namespace

Mat4 gaussNewtonCovariance(const EvidenceCost& cost, const Vec4& x) {
  Mat4 H;
  Vec4 g;
  cost.linearise(x, &H, &g);
  H.diagonal().array() += 1 / kUnknownVariance;
  const Mat4 C = H.inverse();
  return 0.5 * (C + C.transpose());
}

Mat4 exploredCovariance(const EvidenceCost& cost, const Vec4& x, const Mat4& C,
                        const Vec3& middle_B, double lever) {
  Vec4 centre = x;
  descend(cost, &centre);
  Mat4 moments[4];
  Mat4 information = C.inverse(), out = C;
  for (int i = 0; i < 4; ++i) {
    moments[i] = momentsOf(cost, centre, i, std::sqrt(C(i, i)), middle_B, lever);
    if (moments[i](i, i) < out(i, i) && moments[i](i, i) > 0) {
      information(i, i) += 1 / moments[i](i, i) - 1 / out(i, i);
      out = information.inverse();
    }
  }
  const Vec4 scale(lever, 1, 1, 1);
  Mat4 scaled = scale.asDiagonal() * out * scale.asDiagonal();
  for (const Mat4& m : moments) {
    const Eigen::SelfAdjointEigenSolver<Mat4> eigen(scale.asDiagonal() * m * scale.asDiagonal());
    const Vec4 along = eigen.eigenvectors().col(3);
    const double excess = eigen.eigenvalues()[3] - along.dot(scaled * along);
    if (excess > 0) scaled += excess * along * along.transpose();
  }
  const Vec4 back = scale.cwiseInverse();
  out = back.asDiagonal() * scaled * back.asDiagonal();
  return 0.5 * (out + out.transpose());
}

HeightMean heightMean(const EvidenceCost& cost, const Vec4& x, double sigma) {
  constexpr int kStepsPerSigma = 8, kFarthestSigmas = 6;
  const double step = std::min(sigma, kFarthest / kFarthestSigmas) / kStepsPerSigma;
  const Vec4 axis = Vec4::Unit(3);
  const double here = cost(x);
  double weights = 1, second = 0;
  Vec4 sum = Vec4::Zero();
  for (const double sign : {-1.0, 1.0}) {
    Vec4 moved = x;
    for (int i = 0; i < kStepsPerSigma * kFarthestSigmas; ++i) {
      moved[3] += sign * step;
      const double rise = descend(cost, &moved, {kIterations, 1e-3, &axis}) - here;
      const double weight = std::exp(-0.5 * std::clamp(rise, -100.0, 100.0));
      weights += weight;
      sum += weight * (moved - x);
      second += weight * (moved[3] - x[3]) * (moved[3] - x[3]);
      if (rise > kMostRise) break;
    }
  }
  const Vec4 mean = sum / weights;
  return {x + mean, second / weights - mean[3] * mean[3]};
}

}  // namespace vir::team
