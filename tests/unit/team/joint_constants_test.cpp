/// What is the same all along a robot's path, and bends it: where it turns, and how its heading
/// errs on the way and in turns.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "vir/core/angles.h"
#include "vir/team/joint_solution.h"
#include "vir_test_noise.h"

namespace vir::team {
namespace {

/// Two robots on a floor, 5 m apart, that drive rounded squares one way round.
struct World {
  std::vector<JointRobot> robots;
  std::vector<JointMutualRange> mutual;
  std::vector<Vec3> truth[2];
};

struct Errors {
  Vec3 centre = Vec3::Zero();  ///< the body's origin, seen from what turns [m]
  double per_m = 0, per_rad = 0;
};

/// The odometry is that of what turns; antennas are at the bodies' origins.
World make(const Errors& errors) {
  World out;
  test::Noise noise(5);
  const Vec3 anchor(2, 3, 0.5);
  std::vector<Vec3> antenna[2];
  for (int robot = 0; robot < 2; ++robot) {
    JointRobot r;
    // Straight for 1.5 m, then a quarter turn on a radius of 0.2 m.
    const double straight = 1.5, quarter = 0.2 * M_PI / 2, speed = 0.25;
    Vec3 p(5.0 * robot, 0.3 * robot, 0), p_O = Vec3::Zero();
    double yaw = 0.4 * robot, yaw_O = 0, way = 0.4 * robot;
    for (int k = 0; k <= 2400; ++k) {
      const Vec3 body = p + rotZ(yaw) * errors.centre;
      antenna[robot].push_back(body);
      r.odometry.push_back({fromSeconds(0.05 * k), {Quat(rotZ(yaw_O)), p_O}});
      out.truth[robot].push_back(body);
      if (k % 4 == 0) {
        r.anchor_ranges.push_back({fromSeconds(0.05 * k), 4,
                                   (body - anchor).norm() + 0.03 * noise.normal(), 0.03,
                                   Vec3::Zero()});
      }
      const double metres = 0.05 * speed;
      way = std::fmod(way + metres, straight + quarter);
      const double turn = way > straight ? metres / 0.2 : 0;
      p += rotZ(yaw + turn / 2) * Vec3(metres, 0, 0);
      yaw += turn;
      // The heading of the odometry misses so much.
      const double turn_O = turn - errors.per_m * metres - errors.per_rad * turn;
      p_O += rotZ(yaw_O + turn_O / 2) * Vec3(metres, 0, 0);
      yaw_O += turn_O;
    }
    r.estimate = r.odometry;
    out.robots.push_back(r);
  }
  for (std::size_t k = 1; k < antenna[0].size(); k += 4) {
    const double d = (antenna[0][k] - antenna[1][k]).norm() + 0.03 * noise.normal();
    out.mutual.push_back(
        {fromSeconds(0.05 * static_cast<double>(k)), 0, 1, d, 0.03, Vec3::Zero(), Vec3::Zero()});
  }
  out.robots[1].T_C_W = {0.4 + 0.05, Vec3(5.1, 0.2, 0)};
  return out;
}

/// Of a robot, in the frame where robot 0 fits best.
double pathError(const World& world, const JointSolution& s, std::size_t robot) {
  Eigen::Matrix3Xd from(3, static_cast<long>(world.truth[0].size())), to = from;
  for (long k = 0; k < from.cols(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    from.col(k) = s.trajectories[0][i].T_W_B.p;
    to.col(k) = world.truth[0][i];
  }
  const Eigen::Isometry3d T(Eigen::umeyama(from, to, false));
  double sum = 0;
  for (std::size_t i = 0; i < world.truth[robot].size(); ++i) {
    sum += (T * s.trajectories[robot][i].T_W_B.p - world.truth[robot][i]).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(world.truth[robot].size()));
}

/// Of either robot [m].
std::pair<double, double> solved(const Errors& errors, const JointOptions& options) {
  const World world = make(errors);
  const JointSolution s = solveJointly(world.robots, world.mutual, options);
  EXPECT_TRUE(s.solved) << s.problem;
  if (!s.solved) return {1e9, 1e9};
  return {pathError(world, s, 0), pathError(world, s, 1)};
}

/// Loops whose heading goes with them are turned, or made wider, by what is ahead or aside.
TEST(JointConstants, WhereABodyTurns) {
  const Errors errors{Vec3(0.08, 0.03, 0), 0, 0};
  JointOptions believed;
  believed.centre_sigma_m = 0;
  const auto without = solved(errors, believed), with = solved(errors, {});
  EXPECT_LT(with.first, 0.01);
  EXPECT_GT(without.first, 0.03);
  EXPECT_LT(with.second, 0.03);
}

TEST(JointConstants, AHeadingThatErrsAllTheWay) {
  const Errors errors{Vec3::Zero(), 0.01, -0.005};
  JointOptions believed;
  believed.heading_per_m = believed.heading_per_rad = 0;
  const auto without = solved(errors, believed), with = solved(errors, {});
  EXPECT_LT(with.first, 0.01);
  EXPECT_GT(without.first, 0.03);
  EXPECT_LT(with.second, 0.03);
}

/// A device that says nothing for two seconds and has not counted meanwhile: half a metre is lost.
TEST(JointConstants, AGapInTheOdometryTearsNothing) {
  World world = make({});
  std::vector<StampedPose>& odometry = world.robots[1].odometry;
  const auto first = odometry.begin() + 1000, last = first + 40;
  const Pose back = first->T_W_B * last->T_W_B.inverse();
  for (auto p = last; p != odometry.end(); ++p) p->T_W_B = back * p->T_W_B;
  odometry.erase(first + 1, last);
  world.robots[1].estimate = odometry;
  world.truth[1].erase(world.truth[1].begin() + 1001, world.truth[1].begin() + 1040);
  const JointSolution s = solveJointly(world.robots, world.mutual, {});
  ASSERT_TRUE(s.solved) << s.problem;
  EXPECT_LT(pathError(world, s, 0), 0.01);
  EXPECT_LT(pathError(world, s, 1), 0.03);
  EXPECT_LT(s.ranges_rejected, 5);
}

TEST(JointConstants, NoneOfThemIsNoWorse) {
  const auto error = solved({}, {});
  EXPECT_LT(error.first, 0.01);
  EXPECT_LT(error.second, 0.03);
}

}  // namespace
}  // namespace vir::team
