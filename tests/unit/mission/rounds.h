#pragma once
/// Ten rounds of 60 m through a hall, an odometry that drifts, and second visits.
#include <cmath>
#include <cstdint>
#include <vector>

#include "vir/core/random.h"
#include "vir/mission/mission_graph.h"

namespace vir_test {

using vir::Pose;
using vir::Quat;
using vir::Vec3;

struct Rounds {
  std::vector<Pose> truth;  ///< per keyframe, half a metre apart
  std::vector<vir::mission::PathNode> path;
  int per_round = 0;
};

struct RoundsOptions {
  int rounds = 10;
  double sigma_m = 0.01, sigma_rad = 0.002;  ///< of the odometry, per root of a metre
  std::uint64_t seed = 1;
  bool knows_covariance = true;
  double held_sigma_m = 0;  ///< above 0: ranges hold the path to this
  std::uint64_t first_id = 1;
};

/// A rectangle of 20 m x 10 m with the body turned along, leaning a little.
inline Pose onTheWay(double along_m) {
  const double s = std::fmod(along_m, 60.0);
  Vec3 p;
  double yaw = 0;
  if (s < 20) {
    p = Vec3(s, 0, 1);
  } else if (s < 30) {
    p = Vec3(20, s - 20, 1);
    yaw = M_PI / 2;
  } else if (s < 50) {
    p = Vec3(50 - s, 10, 1);
    yaw = M_PI;
  } else {
    p = Vec3(0, 60 - s, 1);
    yaw = -M_PI / 2;
  }
  p.z() += 0.3 * std::sin(along_m / 7);
  const Quat lean(Eigen::AngleAxisd(0.1 * std::sin(along_m / 3), Vec3::UnitX()) *
                  Eigen::AngleAxisd(0.2 * std::cos(along_m / 5), Vec3::UnitY()));
  return {Quat(vir::rotZ(yaw)) * lean, p};
}

inline Rounds makeRounds(const RoundsOptions& o) {
  constexpr double kStep = 0.5;
  Rounds out;
  out.per_round = static_cast<int>(60 / kStep);
  vir::Random random(o.seed);
  double turn = 0;
  Vec3 p = Vec3::Zero(), held = Vec3::Zero();
  Eigen::Matrix4d P = Eigen::Matrix4d::Identity() * 1e-6;
  for (int i = 0; i < o.rounds * out.per_round; ++i) {
    const Pose T = onTheWay(i * kStep);
    vir::mission::PathNode node;
    node.id = o.first_id + static_cast<std::uint64_t>(i);
    node.t = static_cast<vir::TimeNs>(i) * 500000000;
    node.held = o.held_sigma_m > 0;
    if (i > 0) {
      const double root = std::sqrt(kStep);
      turn += o.sigma_rad * root * random.normal();
      const Vec3 noise(random.normal(), random.normal(), random.normal());
      const Vec3 moved = vir::rotZ(turn) * (T.p - out.truth.back().p);
      p += moved + o.sigma_m * root * noise;
      Eigen::Matrix4d carry = Eigen::Matrix4d::Identity();
      carry.topRightCorner<3, 1>() = Vec3::UnitZ().cross(moved);
      P = carry * P * carry.transpose();
      P.diagonal().head<3>().array() += o.sigma_m * o.sigma_m * kStep;
      P(3, 3) += o.sigma_rad * o.sigma_rad * kStep;
      held = 0.99 * held + o.held_sigma_m * std::sqrt(1 - 0.99 * 0.99) * noise;
    } else {
      p = T.p;
    }
    node.T_W_B = Pose(Quat(vir::rotZ(turn)) * T.q, p);
    if (o.held_sigma_m > 0) node.T_W_B = Pose(T.q, T.p + held);
    out.truth.push_back(T);
    if (o.knows_covariance) {
      // The yaw's variance along the body's rotation on the right.
      const Vec3 up = node.T_W_B.R().row(2).transpose();
      Eigen::Matrix<double, 6, 4> J = Eigen::Matrix<double, 6, 4>::Zero();
      J.topLeftCorner<3, 3>().setIdentity();
      J.bottomRightCorner<3, 1>() = up;
      Eigen::Matrix4d Q = P;
      if (o.held_sigma_m > 0) {
        Q.setZero();
        Q.diagonal() << Vec3::Constant(o.held_sigma_m * o.held_sigma_m), 1e-6;
      }
      node.covariance = J * Q * J.transpose();
    }
    out.path.push_back(node);
  }
  return out;
}

/// What a second look says: the true relative pose with noise.
inline vir::Loop trueLoop(const Rounds& r, int older, int newer, vir::Random* random,
                          double sigma_m = 0.02, double sigma_rad = 0.003) {
  vir::Loop loop;
  loop.older = r.path[static_cast<std::size_t>(older)].id;
  loop.newer = r.path[static_cast<std::size_t>(newer)].id;
  loop.T_older_newer =
      r.truth[static_cast<std::size_t>(older)].inverse() * r.truth[static_cast<std::size_t>(newer)];
  const auto three = [&] { return Vec3(random->normal(), random->normal(), random->normal()); };
  loop.T_older_newer.p += sigma_m * three();
  loop.T_older_newer.q = loop.T_older_newer.q * vir::expQuat(sigma_rad * three());
  loop.covariance.diagonal() << Vec3::Constant(sigma_m * sigma_m),
      Vec3::Constant(sigma_rad * sigma_rad);
  loop.matches = 100;
  loop.inliers = 60;
  return loop;
}

/// Root mean square distance [m] of positions to the truth; the first poses lie on one another.
inline double ateOf(const std::vector<vir::StampedPose>& path, const Rounds& r) {
  double sum = 0;
  for (std::size_t i = 0; i < path.size(); ++i) {
    sum += (path[i].T_W_B.p - r.truth[i].p).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(path.size()));
}

}  // namespace vir_test
