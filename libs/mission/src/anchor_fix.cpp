#include "anchor_fix.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <utility>

namespace vir::mission {
namespace {

/// What an anchor's covariance does not know of: no line of sight, a bias of its own [m].
constexpr double kAnchorSigma = 0.1;
/// Anchors nearer to one another, horizontally, do not say where north is [m].
constexpr double kApart = 1;
constexpr int kSteps = 3;
/// 0.1 % of right ones are beyond, by degrees of freedom from 2 on.
double gateOf(int dof) { return dof + 3.1 * std::sqrt(2.0 * dof) + 6; }

struct Pair {
  const Anchor *in_M, *in_W;
};

std::vector<Pair> pairsOf(const std::vector<Anchor>& in_M, const std::vector<Anchor>& in_W) {
  std::vector<Pair> out;
  for (const Anchor& a : in_M) {
    for (const Anchor& b : in_W) {
      if (a.id == b.id && isKnown(a) && isKnown(b)) out.push_back({&a, &b});
    }
  }
  return out;
}

Mat3 covarianceOf(const Pair& p, const Mat3& R_M_W) {
  return p.in_M->covariance + R_M_W * p.in_W->covariance * R_M_W.transpose() +
         kAnchorSigma * kAnchorSigma * Mat3::Identity();
}

}  // namespace

bool isKnown(const Anchor& a) {
  const bool settled = a.state == AnchorState::estimated || a.state == AnchorState::fixed;
  return settled && a.has_position && a.p_W.allFinite() && a.covariance.allFinite();
}

bool fits(const Anchor& a, const Anchor& b) {
  const AnchorFit fit = anchorFit({LevelTransform(), Eigen::Matrix4d::Zero()}, {a}, {b});
  return fit.chi2 <= gateOf(fit.dof);
}

std::optional<LevelGuess> fixByAnchors(const std::vector<Anchor>& in_M,
                                       const std::vector<Anchor>& in_W) {
  const std::vector<Pair> pairs = pairsOf(in_M, in_W);
  if (pairs.size() < 2) return std::nullopt;
  Vec3 mean_M = Vec3::Zero(), mean_W = Vec3::Zero();
  for (const Pair& p : pairs) {
    mean_M += p.in_M->p_W / static_cast<double>(pairs.size());
    mean_W += p.in_W->p_W / static_cast<double>(pairs.size());
  }
  double along = 0, across = 0, spread = 0;
  for (const Pair& p : pairs) {
    const Vec3 a = p.in_M->p_W - mean_M, b = p.in_W->p_W - mean_W;
    along += b.x() * a.x() + b.y() * a.y();
    across += b.x() * a.y() - b.y() * a.x();
    spread = std::max(spread, a.head<2>().norm());
  }
  if (!(2 * spread > kApart)) return std::nullopt;
  LevelGuess out;
  out.T.yaw_rad = std::atan2(across, along);
  out.T.t_m = mean_M - rotZ(out.T.yaw_rad) * mean_W;
  for (int step = 0; step < kSteps; ++step) {
    Eigen::Matrix4d H = Eigen::Matrix4d::Zero();
    Eigen::Vector4d b = Eigen::Vector4d::Zero();
    const Mat3 R = rotZ(out.T.yaw_rad);
    for (const Pair& p : pairs) {
      Eigen::Matrix<double, 3, 4> J;
      J << Mat3::Identity(), Vec3::UnitZ().cross(R * p.in_W->p_W);
      const Mat3 weight = covarianceOf(p, R).inverse();
      H += J.transpose() * weight * J;
      b += J.transpose() * weight * (p.in_M->p_W - out.T * p.in_W->p_W);
    }
    const Eigen::LDLT<Eigen::Matrix4d> solver(H);
    const Eigen::Vector4d change = solver.solve(b);
    if (!(solver.vectorD().minCoeff() > 0) || !change.allFinite()) return std::nullopt;
    out.T.t_m += change.head<3>();
    out.T.yaw_rad += change(3);
    out.P = solver.solve(Eigen::Matrix4d::Identity());
  }
  const AnchorFit fit = anchorFit({out.T, Eigen::Matrix4d::Zero()}, in_M, in_W);
  if (!(fit.chi2 <= gateOf(fit.dof - 4))) return std::nullopt;
  return out;
}

AnchorFit anchorFit(const LevelGuess& T_M_W, const std::vector<Anchor>& in_M,
                    const std::vector<Anchor>& in_W) {
  AnchorFit out;
  const Mat3 R = rotZ(T_M_W.T.yaw_rad);
  for (const Pair& p : pairsOf(in_M, in_W)) {
    Eigen::Matrix<double, 3, 4> J;
    J << Mat3::Identity(), Vec3::UnitZ().cross(R * p.in_W->p_W);
    const Mat3 S = covarianceOf(p, R) + J * T_M_W.P * J.transpose();
    const Vec3 e = p.in_M->p_W - T_M_W.T * p.in_W->p_W;
    out.chi2 += e.dot(S.ldlt().solve(e));
    out.dof += 3;
  }
  return out;
}

}  // namespace vir::mission
