#include "graph_edges.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace vir::mission {
namespace {

/// What even a robot that stands moves by between two keyframes, as far as anybody knows.
constexpr double kLeastSigmaM = 5e-4, kLeastSigmaRad = 5e-5;
/// The estimator's growth is not believed below this part of the drift that goes without saying.
constexpr double kBelieved = 0.1;
constexpr double kLostYawSigma = 0.3;  // [rad]
/// Nor above this times it: differences of large covariances are noise.
constexpr double kWorst = 4;
/// A keyframe keeps at least this part of its neighbour's error.
constexpr double kLeastShared = 0.05;

/// Variances of a step: what goes without saying, and what statements of it are kept between.
struct Bounds {
  double unknown_m, believed_m, most_m;        // [m^2]
  double unknown_rad, believed_rad, most_rad;  // [rad^2]
};
Bounds boundsOf(double length_m, const GraphOptions& o) {
  const double drift_m = o.drift_m_per_sqrt_m * o.drift_m_per_sqrt_m * length_m;
  const double drift_rad = o.drift_rad_per_sqrt_m * o.drift_rad_per_sqrt_m * length_m;
  const double least_m = kLeastSigmaM * kLeastSigmaM, least_rad = kLeastSigmaRad * kLeastSigmaRad;
  return {drift_m + least_m,     kBelieved * drift_m + least_m,     kWorst * drift_m + least_m,
          drift_rad + least_rad, kBelieved * drift_rad + least_rad, kWorst * drift_rad + least_rad};
}

/// One kind of error, as a variance at a keyframe.
void split(double before, double after, double least, double most, bool held, double* way,
           double* tie) {
  *way = std::clamp(after - before, least, most);
  *tie = 0;
  // Without ranges it is what the short window did not know yet that shrinks.
  if (!held || before <= 0 || after >= before + least) return;
  // It has shrunk: fast, as when anchors were just found, or slowly, as while they hold.
  const double fast = after / before;
  const double slow = std::sqrt(std::max(0.0, after - least) / before);
  const bool fell = after * (1 - fast) > least;
  const double a = std::clamp(fell ? fast : slow, kLeastShared, 1.0);
  const double w = fell ? after * (1 - fast) : least;
  *way = w / a;
  if (a < 1) *tie = w / ((1 - a) * (1 - a));
}

}  // namespace

Eigen::Matrix4d levelCovariance(const Eigen::Matrix<double, 6, 6>& covariance, const Mat3& R_W_B) {
  Eigen::Matrix<double, 4, 6> J = Eigen::Matrix<double, 4, 6>::Zero();
  J.topLeftCorner<3, 3>().setIdentity();
  J.bottomRightCorner<1, 3>() = R_W_B.row(2);
  return J * covariance * J.transpose();
}

Eigen::Matrix4d transportOf(const Eigen::Matrix4d& from, const Eigen::Matrix4d& to) {
  const auto root = [](const Eigen::Matrix4d& P, bool inverse) -> Eigen::Matrix4d {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> e(0.5 * (P + P.transpose()));
    const double floor = 1e-12 * std::max(e.eigenvalues()(3), 1e-18);
    const Eigen::Vector4d values = e.eigenvalues().cwiseMax(floor).cwiseSqrt();
    const Eigen::Vector4d taken = inverse ? values.cwiseInverse().eval() : values;
    return e.eigenvectors() * taken.asDiagonal() * e.eigenvectors().transpose();
  };
  const Eigen::Matrix4d A = root(from, false), B = root(from, true);
  return B * root(A * to * A, false) * B;
}

StepNoise followedNoise(const PathNode& before, const PathNode& node, const GraphOptions& o) {
  const Vec3 motion = node.T_W_B.p - before.T_W_B.p;
  const Bounds b = boundsOf(motion.norm(), o);
  StepNoise out;
  const Eigen::Matrix4d then = levelCovariance(before.covariance, before.T_W_B.R());
  const Eigen::Matrix4d now = levelCovariance(node.covariance, node.T_W_B.R());
  if (!(then.trace() > 0) || !(now.trace() > 0)) {
    out.way << Vec3::Constant(b.unknown_m), b.unknown_rad;
    return out;
  }
  // The error of the yaw has moved the keyframe as well: no growth of its own.
  Eigen::Matrix4d carry = Eigen::Matrix4d::Identity();
  carry.topRightCorner<3, 1>() = Vec3::UnitZ().cross(motion);
  const Eigen::Matrix4d carried = carry * then * carry.transpose();
  const auto horizontal = [](const Eigen::Matrix4d& P) { return 0.5 * (P(0, 0) + P(1, 1)); };
  double way = 0, tie = 0;
  split(horizontal(carried), horizontal(now), b.believed_m, b.most_m, node.held, &way, &tie);
  out.way.head<2>().setConstant(way);
  out.tie.head<2>().setConstant(tie);
  split(carried(2, 2), now(2, 2), b.believed_m, b.most_m, node.held, &out.way[2], &out.tie[2]);
  split(carried(3, 3), now(3, 3), b.believed_rad, b.most_rad, node.held, &out.way[3], &out.tie[3]);
  return out;
}

Eigen::Vector4d odometryNoise(const PathNode& before, const PathNode& node,
                              const Eigen::Vector4d& stated, const GraphOptions& o) {
  const Bounds b = boundsOf((node.T_W_B.p - before.T_W_B.p).norm(), o);
  Eigen::Vector4d out;
  out.head<2>().setConstant(std::clamp(0.5 * (stated[0] + stated[1]), b.believed_m, b.most_m));
  out[2] = std::clamp(stated[2], b.believed_m, b.most_m);
  out[3] = std::clamp(stated[3], b.believed_rad, b.most_rad);
  return out;
}

StepNoise lostNoise(const PathNode& before, const PathNode& node, const GraphOptions& o) {
  const double sigma = o.lost_m + o.lost_mps * std::max(0.0, toSeconds(node.t - before.t));
  StepNoise out;
  out.way << Vec3::Constant(sigma * sigma), kLostYawSigma * kLostYawSigma;
  return out;
}

LevelLoop levelLoop(const Loop& loop, const Pose& older, const Pose& newer, const GraphOptions& o) {
  LevelLoop out;
  const Mat3 R_older = older.R(), R_newer = newer.R();
  out.motion_W = R_older * loop.T_older_newer.p;
  // What turns the newer's axes, as the estimator has them, to those that the loop says.
  const Mat3 turn = R_older * loop.T_older_newer.R() * R_newer.transpose();
  out.turn_rad = nearestYaw(turn);
  out.tilt_rad = std::atan2(turn.col(2).head<2>().norm(), turn(2, 2));
  Eigen::Matrix<double, 4, 6> J = Eigen::Matrix<double, 4, 6>::Zero();
  J.topLeftCorner<3, 3>() = R_older;
  J.bottomRightCorner<1, 3>() = R_newer.row(2);
  out.covariance = J * loop.covariance * J.transpose();
  out.covariance.diagonal().head<3>().array() += o.loop_sigma_m * o.loop_sigma_m;
  out.covariance(3, 3) += o.loop_sigma_rad * o.loop_sigma_rad;
  return out;
}

Eigen::Matrix4d sqrtInformation(const Eigen::Matrix4d& covariance) {
  const Eigen::Matrix4d L = covariance.llt().matrixL();
  return L.triangularView<Eigen::Lower>().solve(Eigen::Matrix4d::Identity());
}

}  // namespace vir::mission
