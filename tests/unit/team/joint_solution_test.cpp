#include "vir/team/joint_solution.h"

#include <Eigen/Dense>
//
#include <gtest/gtest.h>

#include <cmath>

#include "vir_test_noise.h"

namespace vir::team {
namespace {

struct Made {
  std::vector<JointRobot> robots;
  std::vector<JointMutualRange> mutual;
  std::vector<std::vector<StampedPose>> truth;  // per robot, in the world of robot 0's start
  WorldTransform T_0_1;                         // between the two odometry worlds
  Vec3 anchor = Vec3(-1, 3, 1);
};

struct Setting {
  double sigma_m = 0.05, turn_per_s = 0.002, scale = 1.05;
  bool anchor = true, noise = true, planar = false;
};

/// Two robots for a hundred seconds; each one's odometry turns slowly and is 5 % long.
Made make(const Setting& s, std::uint64_t seed) {
  test::Noise noise(seed);
  Made out;
  const double start[2][2] = {{0.3, 1.2}, {2.1, 0.4}};
  const auto pathOf = [&](int robot, double t) {
    const double h = s.planar ? 0 : 0.5;
    return Vec3(2.5 * std::sin(0.21 * t + start[robot][0]) + 2 * robot,
                2.0 * std::sin(0.33 * t + start[robot][1]), h * std::sin(0.17 * t + robot));
  };
  const auto headingOf = [&](int robot, double t) { return 0.2 * std::sin(0.1 * t) + robot; };
  std::vector<WorldTransform> T_O_W;
  for (int robot = 0; robot < 2; ++robot) {
    const Pose first(Quat(rotZ(headingOf(robot, 0))), pathOf(robot, 0));
    // Worlds begin at the robots.
    const WorldTransform T_W_O{headingOf(robot, 0), first.p};
    T_O_W.push_back(T_W_O.inverse());
    JointRobot r;
    std::vector<StampedPose> truth;
    Vec3 p_O = Vec3::Zero(), last = first.p;
    double turned = 0;
    for (int k = 0; k <= 1000; ++k) {
      const double t = 0.1 * k;
      const Vec3 p = pathOf(robot, t);
      turned += 0.1 * s.turn_per_s * (robot == 0 ? 1 : -1);
      p_O += s.scale * (rotZ(turned) * (rotZ(T_O_W.back().yaw_rad) * (p - last)));
      last = p;
      const double yaw = headingOf(robot, t) - headingOf(robot, 0) + turned;
      r.odometry.push_back({fromSeconds(t), {Quat(rotZ(yaw)), p_O}});
      truth.push_back({fromSeconds(t), {Quat(rotZ(headingOf(robot, t))), p}});
      if (k % 2 == 0 && s.anchor) {
        const double n = s.noise ? s.sigma_m * noise.normal() : 0;
        r.anchor_ranges.push_back(
            {fromSeconds(t), 4, (p - out.anchor).norm() + n, s.sigma_m, Vec3::Zero()});
      }
    }
    r.estimate = r.odometry;
    out.robots.push_back(r);
    out.truth.push_back(truth);
  }
  for (int k = 5; k < 1000; k += 2) {
    const double t = 0.1 * k;
    const double n = s.noise ? s.sigma_m * noise.normal() : 0;
    out.mutual.push_back({fromSeconds(t), 0, 1, (pathOf(0, t) - pathOf(1, t)).norm() + n, s.sigma_m,
                          Vec3::Zero(), Vec3::Zero()});
  }
  out.T_0_1 = T_O_W[0] * T_O_W[1].inverse();
  // As found beforehand: roughly.
  out.robots[1].T_C_W = {out.T_0_1.yaw_rad + 0.1, out.T_0_1.t_m + Vec3(0.3, -0.2, 0)};
  for (auto& list : out.truth) {
    for (StampedPose& p : list) p.T_W_B = T_O_W[0].pose() * p.T_W_B;
  }
  out.anchor = T_O_W[0] * out.anchor;
  return out;
}

double rmse(const std::vector<StampedPose>& a, const std::vector<StampedPose>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i].T_W_B.p - b[i].T_W_B.p).squaredNorm();
  return std::sqrt(sum / static_cast<double>(a.size()));
}

TEST(JointSolution, MutualRangesStraightenBothPaths) {
  const Made made = make({}, 1);
  const JointSolution s = solveJointly(made.robots, made.mutual, {});
  ASSERT_TRUE(s.solved) << s.problem;
  // Alone: robot 0 turns by 11 deg and is 5 % long.
  EXPECT_GT(rmse(made.robots[0].odometry, made.truth[0]), 0.3);
  EXPECT_LT(rmse(s.trajectories[0], made.truth[0]), 0.12);
  EXPECT_LT(rmse(s.trajectories[1], made.truth[1]), 0.12);
  ASSERT_EQ(s.anchors.count(4), 1u);
  EXPECT_LT((s.anchors.at(4).p_C - made.anchor).head<2>().norm(), 0.2);
  EXPECT_EQ(s.ranges_rejected, 0);
}

TEST(JointSolution, WithoutAnchors) {
  Setting setting;
  setting.anchor = false;
  setting.scale = 1;
  setting.turn_per_s = 0.001;
  const Made made = make(setting, 2);
  const JointSolution s = solveJointly(made.robots, made.mutual, {});
  ASSERT_TRUE(s.solved) << s.problem;
  EXPECT_TRUE(s.anchors.empty());
  EXPECT_LT(rmse(s.trajectories[1], made.truth[1]), 0.25);
}

TEST(JointSolution, ExactOdometryAndRangesGiveTheExactTransform) {
  Setting setting;
  setting.noise = false;
  setting.turn_per_s = 0;
  setting.scale = 1;
  const Made made = make(setting, 3);
  const JointSolution s = solveJointly(made.robots, made.mutual, {});
  ASSERT_TRUE(s.solved) << s.problem;
  const WorldTransform T = s.between(0, 1);
  EXPECT_NEAR(wrapAngle(T.yaw_rad - made.T_0_1.yaw_rad), 0, 1e-4);
  EXPECT_NEAR((T.t_m - made.T_0_1.t_m).norm(), 0, 1e-3);
  EXPECT_LT(rmse(s.trajectories[0], made.truth[0]), 1e-3);
}

TEST(JointSolution, LevelRobotsKeepTheirHeight) {
  Setting setting;
  setting.planar = true;
  const Made made = make(setting, 4);
  const JointSolution s = solveJointly(made.robots, made.mutual, {});
  ASSERT_TRUE(s.solved) << s.problem;
  for (const auto& list : s.trajectories) {
    for (const StampedPose& p : list) ASSERT_NEAR(p.T_W_B.p.z(), 0, 0.02);
  }
}

TEST(JointSolution, OutliersAreNotFollowed) {
  Made made = make({}, 5);
  test::Noise noise(6);
  for (JointMutualRange& r : made.mutual) {
    if (noise.uniform() < 0.2) r.range_m += 0.5 + 3 * noise.uniform();
  }
  made.mutual[10].range_m = std::nan("");
  const JointSolution s = solveJointly(made.robots, made.mutual, {});
  ASSERT_TRUE(s.solved) << s.problem;
  EXPECT_LT(rmse(s.trajectories[1], made.truth[1]), 0.2);
  EXPECT_GT(s.ranges_rejected, 50);
}

TEST(JointSolution, SaysWhyThereIsNone) {
  EXPECT_FALSE(solveJointly({}, {}, {}).solved);
  Made made = make({}, 7);
  made.robots[1].odometry.clear();
  const JointSolution s = solveJointly(made.robots, made.mutual, {});
  EXPECT_FALSE(s.solved);
  EXPECT_FALSE(s.problem.empty());
}

TEST(JointSolution, SameTwice) {
  const Made made = make({}, 8);
  const JointSolution a = solveJointly(made.robots, made.mutual, {});
  const JointSolution b = solveJointly(made.robots, made.mutual, {});
  EXPECT_EQ(a.T_C_W[1].t_m, b.T_C_W[1].t_m);
  EXPECT_EQ(a.trajectories[1].back().T_W_B.p, b.trajectories[1].back().T_W_B.p);
}

}  // namespace
}  // namespace vir::team
