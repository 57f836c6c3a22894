/// A world that moves under the path: whose steps are flown, and whose are not.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "vir/core/angles.h"
#include "vir/mission/mission_graph.h"

namespace vir::mission {
namespace {

/// With a single anchor W moves as that becomes known: the path in it has a step that nobody flew.
/// Odometry has not, and says so once loops act; `pivots`: the graph is told.
double worstAfterAStepOfW(bool pivots, bool with_loop) {
  constexpr int kNodes = 61, kStepAt = 20;
  const Pose T_O_W(Quat(Eigen::AngleAxisd(0.8, Vec3::UnitZ())), Vec3(5, -3, 1));
  const Vec3 step(0.1, -0.05, 0.02);
  MissionGraph graph({});
  std::vector<Pose> truth;
  for (int k = 0; k < kNodes; ++k) {
    const double a = 2 * kPi * k / (kNodes - 1);
    truth.emplace_back(Quat(Eigen::AngleAxisd(a, Vec3::UnitZ())),
                       Vec3(5 * std::sin(a), 5 - 5 * std::cos(a), 1));
    PathNode n;
    n.id = static_cast<std::uint64_t>(k + 1);
    n.t = fromSeconds(0.4 * k);
    n.T_W_B = truth.back();
    if (k >= kStepAt) n.T_W_B.p += step;
    n.covariance.diagonal().setConstant(1e-6 * (k + 1));
    n.pivots = pivots;
    graph.add(n);
  }
  for (int k = 0; k < kNodes; ++k) {
    Pose T_W_B = truth[static_cast<std::size_t>(k)];
    if (k >= kStepAt) T_W_B.p += step;
    const Odometry odometry{T_O_W * truth[static_cast<std::size_t>(k)],
                            Eigen::Vector4d(1e-5, 1e-5, 1e-6, 1e-8) * (k + 1)};
    graph.move(static_cast<std::uint64_t>(k + 1), T_W_B, odometry);
  }
  if (with_loop) {
    Loop loop;
    loop.older = 1;
    loop.newer = kNodes;
    loop.T_older_newer = truth.front().inverse() * truth.back();
    loop.covariance.diagonal().setConstant(1e-6);
    graph.offer(loop);
  }
  graph.takeOdometry();
  graph.solve();
  double worst = 0;
  const std::vector<StampedPose> path = graph.path();
  for (std::size_t k = 0; k < path.size(); ++k) {
    worst = std::max(worst, (path[k].T_W_B.p - truth[k].p).norm());
  }
  return worst;
}

TEST(MissionGraph, StepsAreThoseOfTheOdometryWhereASingleAnchorMovesTheWorld) {
  EXPECT_LT(worstAfterAStepOfW(true, true), 1e-6);
  EXPECT_GT(worstAfterAStepOfW(false, true), 0.03);  // spread over the round
  // Without loops the path is the estimator's.
  EXPECT_NEAR(worstAfterAStepOfW(true, false), Vec3(0.1, -0.05, 0.02).norm(), 1e-9);
}

}  // namespace
}  // namespace vir::mission
