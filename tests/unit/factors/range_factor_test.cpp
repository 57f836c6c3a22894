/// The factors of ranges.
#include "vir/factors/range_factor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "nodes.h"
#include "vir/factors/head_range_factor.h"
#include "vir/factors/mutual_range_factor.h"
#include "vir/factors/node_range_difference_factor.h"
#include "vir/factors/node_range_factor.h"
#include "vir/factors/window_range_factor.h"
#include "vir_test_jacobian.h"
#include "vir_test_poses.h"

namespace vir::factors {
namespace {

using test::difficultNodes;
using test::NamedNode;
using vir_test::Blocks;
using vir_test::poseBlock;
using vir_test::residualOf;

/// No robust loss: the residual is the plain whitened one.
RangeTerm plain(double range_m, double sigma_m) {
  RangeTerm term{range_m, sigma_m, {}};
  term.robust.huber_delta = term.robust.nlos_delta = 0;
  return term;
}

/// Ranges that put the residual into the core of the loss and into either tail.
std::vector<double> rangeErrors() { return {-3.0, -0.15, 0.0, 0.04, 0.3, 2.0}; }

TEST(PredictRange, ByHand) {
  // |(3, 4, 0)| + 0.2 - 5.5 = -0.3.
  const RangePrediction r = predictRange(Vec3(4, 5, 1), Vec3(1, 1, 1), 0.2, 5.5);
  EXPECT_NEAR(r.value_m, -0.3, 1e-15);
  EXPECT_LT((r.direction - Vec3(0.6, 0.8, 0)).norm(), 1e-15);
}

TEST(PredictRange, DirectionFadesOutAtTheAnchor) {
  const RangePrediction at = predictRange(Vec3(1, 2, 3), Vec3(1, 2, 3), 0, 0.1);
  EXPECT_NEAR(at.value_m, -0.1, 1e-15);
  EXPECT_EQ(at.direction.norm(), 0);
  double last = 0;
  for (double d : {1e-300, 1e-12, 1e-6, 1e-3, 0.01, 0.049, kMinDistance}) {
    const RangePrediction r = predictRange(Vec3(0, d, 0), Vec3::Zero(), 0, 0.1);
    ASSERT_TRUE(r.direction.allFinite() && std::isfinite(r.value_m)) << d;
    EXPECT_NEAR(r.value_m, d - 0.1, 1e-15);
    EXPECT_NEAR(r.direction.norm(), std::min(1.0, d / kMinDistance), 1e-12) << d;
    EXPECT_GE(r.direction.norm(), last);
    last = r.direction.norm();
  }
  EXPECT_NEAR(predictRange(Vec3(0, 0.3, 0), Vec3::Zero(), 0, 1).direction.norm(), 1, 1e-15);
}

TEST(NodeRangeFactor, ResidualByHand) {
  // Node at (1, 2, 0), O turned by 90 degrees, odometry twice too long: a motion of (2, 0, 1) in O
  // is (0, 1, 0.5) in W, the lever (0, 1, 0) is (-1, 0, 0). Antenna at (0, 3, 0.5), anchor at
  // (0, 0, 4.5): distance 5, with the bias of 0.1 and a range of 4.9 over sigma 0.1: 2.
  const NodeRangeFactor f(plain(4.9, 0.1), Vec3(2, 0, 1), Vec3(0, 1, 0));
  const Eigen::VectorXd r = residualOf(f, {{1, 2, 0, M_PI / 2, std::log(2.0)}, {0, 0, 4.5, 0.1}});
  EXPECT_NEAR(r[0], 2.0, 1e-12);
}

TEST(NodeRangeFactor, JacobiansEverywhere) {
  const Vec3 motion(0.6, -0.3, 0.1), lever(0.1, 0.2, -0.15);
  const std::vector<double> anchor = {2, 3, -1, 0.07};
  for (const NamedNode& n : difficultNodes()) {
    const Mat3 R = rotZ(n.x[3]);
    const Vec3 p_U = Vec3(n.x.data()) + R * (std::exp(-n.x[4]) * motion + lever);
    const double expected = (p_U - Vec3(anchor.data())).norm() + anchor[3];
    for (double error : rangeErrors()) {
      const NodeRangeFactor f({expected + error, 0.1, {}}, motion, lever);
      vir_test::expectJacobians(f, {n.x, anchor}, n.name + ", " + std::to_string(error));
    }
  }
}

TEST(NodeRangeFactor, RobustRegions) {
  const auto at = [](double measured_minus_predicted, double* slope) {
    const NodeRangeFactor f({5 + measured_minus_predicted, 0.1, {}}, Vec3::Zero(), Vec3::Zero());
    Eigen::VectorXd r;
    const auto J = vir_test::analyticJacobians(f, {{5, 0, 0, 0, 0}, {0, 0, 0, 0}}, &r);
    *slope = J[0](0, 0);
    return r[0];
  };
  double slope = 0;
  EXPECT_NEAR(at(0, &slope), 0, 1e-12);
  EXPECT_NEAR(slope, 10, 1e-9);
  // Pseudo-Huber, 40 sigma too short, delta 2: e^2/2 = 4 (sqrt(401) - 1).
  EXPECT_NEAR(at(-4, &slope), std::sqrt(8 * (std::sqrt(401.0) - 1)), 1e-9);
  const double short_gradient = at(-4, &slope) * slope;
  // Cauchy, 40 sigma too long, delta 1.5: e^2/2 = 1.125 log(1 + (40/1.5)^2), of the other sign.
  EXPECT_NEAR(at(4, &slope), -std::sqrt(2.25 * std::log1p(1600 / 2.25)), 1e-9);
  const double long_gradient = -at(4, &slope) * slope;
  // Too short pulls at most with delta; too long lets go: delta^2 / r.
  EXPECT_NEAR(short_gradient * 0.1, 2.0, 0.01);
  EXPECT_NEAR(long_gradient * 0.1, 2.25 / 40, 0.001);
}

TEST(NodeRangeFactor, AtAndNearTheAnchor) {
  for (double d : {0.0, 1e-200, 1e-9, 0.001, 0.02, 0.06, 0.5}) {
    const NodeRangeFactor f(plain(0.3, 0.1), Vec3(0.5, 0, 0), Vec3(0, 0.1, 0));
    const Blocks x = {{-0.5 + d, -0.1, 0, 0, 0}, {0, 0, 0, 0}};
    vir_test::expectNullBlocksWork(f, x, "distance " + std::to_string(d));
    Eigen::VectorXd r;
    const auto J = vir_test::analyticJacobians(f, x, &r);
    EXPECT_NEAR(r[0], (d - 0.3) / 0.1, 1e-9);
    for (const auto& block : J) ASSERT_TRUE(block.allFinite()) << d;
    // The pull on the position fades, the pull on the bias does not.
    EXPECT_NEAR(J[0].leftCols(3).norm(), 10 * std::min(1.0, d / kMinDistance), 1e-6) << d;
    EXPECT_NEAR(J[1](0, 3), 10, 1e-12);
  }
}

TEST(NodeRangeDifferenceFactor, ResidualByHand) {
  // Antenna as above at (0, 3, 0.5); anchor 1 as above: 5 + 0.1. The reference at (0, -9, 5.5) is
  // 13 away, its bias 0.3. 5.1 - 13.3 = -8.2; measured -8.4, over sigma 0.1: 2.
  const NodeRangeDifferenceFactor f(plain(-8.4, 0.1), Vec3(2, 0, 1), Vec3(0, 1, 0));
  const Blocks x = {{1, 2, 0, M_PI / 2, std::log(2.0)}, {0, -9, 5.5, 0.3}, {0, 0, 4.5, 0.1}};
  EXPECT_NEAR(residualOf(f, x)[0], 2.0, 1e-9);
}

TEST(NodeRangeDifferenceFactor, JacobiansEverywhereAndTheSameLossForBothSigns) {
  const Vec3 motion(0.6, -0.3, 0.1), lever(0.1, 0.2, -0.15);
  const std::vector<double> reference = {-4, 1, 2, -0.02}, anchor = {2, 3, -1, 0.07};
  for (const NamedNode& n : difficultNodes()) {
    const Vec3 p_U = Vec3(n.x.data()) + rotZ(n.x[3]) * (std::exp(-n.x[4]) * motion + lever);
    const double expected = (p_U - Vec3(anchor.data())).norm() + anchor[3] -
                            (p_U - Vec3(reference.data())).norm() - reference[3];
    for (double error : rangeErrors()) {
      const NodeRangeDifferenceFactor f({expected + error, 0.1, {}}, motion, lever);
      const Blocks x = {n.x, reference, anchor};
      vir_test::expectJacobians(f, x, n.name + ", " + std::to_string(error));
      const NodeRangeDifferenceFactor other({expected - error, 0.1, {}}, motion, lever);
      EXPECT_NEAR(residualOf(f, x)[0], -residualOf(other, x)[0], 1e-9) << n.name << error;
    }
  }
}

TEST(MutualRangeFactor, ResidualByHand) {
  // The first as above: antenna at (0, 3, 0.5). The second, not turned and right in scale, at
  // (1, 0, 4) + (2, 0, 0) + (0, 0, 0.5): (3, 0, 4.5). Distance sqrt(9 + 9 + 16), range 1 m shorter.
  const double range = std::sqrt(34.0) - 1;
  const MutualRangeFactor f(plain(range, 0.5), {Vec3(2, 0, 1), Vec3(0, 1, 0)},
                            {Vec3(2, 0, 0), Vec3(0, 0, 0.5)});
  const Blocks x = {{1, 2, 0, M_PI / 2, std::log(2.0)}, {1, 0, 4, 0, 0}, {9, 9}, {9, 9}};
  EXPECT_NEAR(residualOf(f, x)[0], 2.0, 1e-12);
}

/// The body looks along y of the odometry, which is along -x of W: its origin is 0.3 m ahead of and
/// 0.1 m left of what turns, so at (-0.3, -0.1) in W.
TEST(MutualRangeFactor, CentreByHand) {
  AntennaAtNode first;
  first.axes_O << 0, -1, 1, 0, 0, 0;
  const MutualRangeFactor f(plain(1, 0.5), first, {});
  const Blocks x = {{0.3, 3.1, 4, M_PI / 2, 0.2}, {0, 0, 0, 1, 0}, {0.3, 0.1}, {9, 9}};
  EXPECT_NEAR(residualOf(f, x)[0], (5 - 1) / 0.5, 1e-12);
}

TEST(MutualRangeFactor, JacobiansEverywhere) {
  AntennaAtNode first{Vec3(0.6, -0.3, 0.1), Vec3(0.1, 0.2, -0.15)};
  AntennaAtNode second{Vec3(-0.2, 0.5, 0.3), Vec3(0.05, -0.1, 0.2)};
  first.axes_O = expQuat(Vec3(0.1, -0.2, 2.5)).toRotationMatrix().leftCols<2>();
  second.axes_O = expQuat(Vec3(0.3, 0.1, -1)).toRotationMatrix().leftCols<2>();
  const std::vector<double> c1 = {0.05, -0.03}, c2 = {-0.08, 0.02};
  const auto at = [&](const NamedNode& n, const AntennaAtNode& a) {
    const std::vector<double>& c = &a == &first ? c1 : c2;
    const Vec3 offset =
        std::exp(-n.x[4]) * a.motion_O + a.lever_O + a.axes_O * Eigen::Vector2d(c[0], c[1]);
    return Vec3(Vec3(n.x.data()) + rotZ(n.x[3]) * offset);
  };
  for (const NamedNode& a : difficultNodes()) {
    for (const NamedNode& b : difficultNodes()) {
      const double expected = (at(a, first) - at(b, second)).norm();
      if (expected < 2 * kMinDistance) continue;
      for (double error : rangeErrors()) {
        const MutualRangeFactor f({expected + error, 0.1, {}}, first, second);
        vir_test::expectJacobians(f, {a.x, b.x, c1, c2}, a.name + ", " + b.name);
      }
    }
  }
}

TEST(CentredRangeFactor, JacobiansEverywhere) {
  AntennaAtNode antenna{Vec3(0.6, -0.3, 0.1), Vec3(0.1, 0.2, -0.15)};
  antenna.axes_O = expQuat(Vec3(0.1, -0.2, 2.5)).toRotationMatrix().leftCols<2>();
  for (const NamedNode& n : difficultNodes()) {
    for (const double range : {1.0, 4.0, 300.0}) {
      const CentredRangeFactor f({range, 0.1, {}}, antenna);
      vir_test::expectJacobians(f, {n.x, {1.5, 2, 3, 0.4}, {0.05, -0.03}}, n.name);
    }
  }
}

/// One antenna that does not move is an anchor without a bias; a centre that is the body's origin
/// says nothing.
TEST(MutualRangeFactor, IsTheRangeToAnAnchor) {
  const Vec3 motion(0.6, -0.3, 0.1), lever(0.1, 0.2, -0.15);
  for (const NamedNode& n : difficultNodes()) {
    const MutualRangeFactor mutual({4, 0.1, {}}, {motion, lever}, {});
    const NodeRangeFactor anchor({4, 0.1, {}}, motion, lever);
    const CentredRangeFactor centred({4, 0.1, {}}, {motion, lever});
    const double expected = residualOf(anchor, {n.x, {1, 2, 3, 0}})[0];
    EXPECT_EQ(residualOf(mutual, {n.x, {1, 2, 3, 0.4, 0}, {0, 0}, {0, 0}})[0], expected) << n.name;
    EXPECT_EQ(residualOf(centred, {n.x, {1, 2, 3, 0}, {0, 0}})[0], expected) << n.name;
  }
}

/// Poses of two frames in O for the factors of the short window.
std::vector<std::pair<vir_test::NamedPose, Pose>> framePairs() {
  std::vector<std::pair<vir_test::NamedPose, Pose>> out;
  const auto all = vir_test::poses();
  for (std::size_t k = 0; k < all.size(); ++k) {
    out.emplace_back(all[k], all[(k * 5 + 3) % all.size()].T);
  }
  return out;
}

TEST(WindowRangeFactor, ResidualByHand) {
  // From (1, 1, 0) to (3, 1, 0) in O, by an odometry whose metres are twice too many: (1, 0, 0).
  // The antenna is 1 m ahead of a body that looks along y: (1, 1, 0), turned by 90 degrees (-1, 1,
  // 0). From the node (1, 2, 0): (0, 3, 0); anchor at (4, 0, 0): distance 5, bias 0, range 5.2,
  // sigma 0.2: -1.
  const WindowRangeFactor f(plain(5.2, 0.2), Vec3::Zero(), Vec3(1, 0, 0));
  const Blocks x = {poseBlock(Pose(expQuat(Vec3(0.3, 0, 0)), Vec3(1, 1, 0))),
                    poseBlock(Pose(Quat(rotZ(M_PI / 2)), Vec3(3, 1, 0))),
                    {1, 2, 0, M_PI / 2, std::log(2.0)},
                    {4, 0, 0, 0}};
  EXPECT_NEAR(residualOf(f, x)[0], -1, 1e-12);
}

/// The antenna seen from the node as the long window will see it once the frame is a node's past.
TEST(WindowRangeFactor, IsTheNodesRangeWhateverTheScale) {
  const Vec3 motion(0.2, -0.1, 0.35), lever(0.1, 0.05, -0.2);
  const std::vector<double> anchor = {5, -3, 1, 0.05};
  for (const auto& [T0, Tj] : framePairs()) {
    for (const NamedNode& n : difficultNodes()) {
      const RangeTerm term{7, 0.1, {}};
      const WindowRangeFactor f(term, motion, lever);
      const NodeRangeFactor node(term, Tj * motion - T0.T.p, Tj.q * lever);
      EXPECT_NEAR(residualOf(f, {poseBlock(T0.T), poseBlock(Tj), n.x, anchor})[0],
                  residualOf(node, {n.x, anchor})[0], 1e-9)
          << T0.name << ", " << n.name;
    }
  }
}

TEST(WindowRangeFactor, JacobiansEverywhere) {
  const Vec3 motion(0.2, -0.1, 0.35), lever(-0.1, 0.15, 0.2);
  const std::vector<double> anchor = {20, 13, -9, 0.07};
  for (const auto& [T0, Tj] : framePairs()) {
    for (const NamedNode& n : difficultNodes()) {
      const Vec3 span = rotZ(n.x[3]) * (std::exp(-n.x[4]) * (Tj * motion - T0.T.p) + Tj.q * lever);
      const double expected = (Vec3(n.x.data()) + span - Vec3(anchor.data())).norm() + anchor[3];
      for (double error : {-1.0, 0.02, 1.0}) {
        const WindowRangeFactor f({expected + error, 0.1, {}}, motion, lever);
        vir_test::expectJacobians(f, {poseBlock(T0.T), poseBlock(Tj), n.x, anchor},
                                  T0.name + ", " + n.name + ", " + std::to_string(error));
      }
    }
  }
}

TEST(WindowRangeFactor, ARigidShiftOfTheWindowChangesNothing) {
  const WindowRangeFactor f({7, 0.1, {}}, Vec3(0.2, -0.1, 0.35), Vec3(0.1, 0, -0.2));
  const Vec3 shift(11, -7, 3);
  for (const auto& [T0, Tj] : framePairs()) {
    const std::vector<double> node = {1, 2, 3, 0.8, 0.1}, anchor = {5, -3, 1, 0.05};
    const Blocks here = {poseBlock(T0.T), poseBlock(Tj), node, anchor};
    const Blocks there = {poseBlock(Pose(T0.T.q, T0.T.p + shift)),
                          poseBlock(Pose(Tj.q, Tj.p + shift)), node, anchor};
    Eigen::VectorXd r, s;
    const auto J = vir_test::analyticJacobians(f, here, &r);
    const auto K = vir_test::analyticJacobians(f, there, &s);
    EXPECT_NEAR(r[0], s[0], 1e-12) << T0.name;
    for (std::size_t k = 0; k < J.size(); ++k) {
      EXPECT_LT((J[k] - K[k]).norm(), 1e-11) << T0.name << ", block " << k;
    }
    // In the equations too: the columns of the two positions cancel exactly.
    EXPECT_EQ((J[0].leftCols(3) + J[1].leftCols(3)).norm(), 0) << T0.name;
    EXPECT_EQ(J[0].block(0, 3, 1, 3).norm(), 0) << "the attitude of frame 0 plays no part";
  }
}

/// Frame 0 has been turned since the window was set up, most of it about the vertical.
Quat before(const Pose& T0, double yaw) {
  return expQuat(Vec3(0.01, -0.02, 0)) * Quat(rotZ(-yaw)) * T0.q;
}

TEST(WindowRangeFactor, JacobiansOfAWindowThatHasTurned) {
  const Vec3 motion(0.2, -0.1, 0.35), lever(-0.1, 0.15, 0.2);
  const std::vector<double> anchor = {20, 13, -9, 0.07};
  for (const auto& [T0, Tj] : framePairs()) {
    for (double yaw : {0.0, 0.03, -1.2, 3.0}) {
      const std::string what = T0.name + ", " + std::to_string(yaw);
      const std::vector<double> node = {1, 2, 3, 0.8, 0.1};
      const WindowRangeFactor f({22, 0.1, {}}, motion, lever, before(T0.T, yaw));
      vir_test::expectJacobians(f, {poseBlock(T0.T), poseBlock(Tj), node, anchor}, what);
      const HeadRangeFactor head({22, 0.1, {}}, motion, lever, before(T0.T, yaw));
      vir_test::expectJacobians(head, {poseBlock(T0.T), node, anchor}, what);
    }
  }
}

TEST(WindowRangeFactor, ATurnOfTheWindowAboutTheVerticalChangesNothing) {
  const Vec3 motion(0.2, -0.1, 0.35), lever(0.1, 0, -0.2), shift(11, -7, 3);
  const std::vector<double> node = {1, 2, 3, 0.8, 0.1}, anchor = {5, -3, 1, 0.05};
  for (const auto& [T0, Tj] : framePairs()) {
    const WindowRangeFactor f({7, 0.1, {}}, motion, lever, T0.T.q);
    const HeadRangeFactor head({7, 0.1, {}}, motion, lever, T0.T.q);
    const double r = residualOf(f, {poseBlock(T0.T), poseBlock(Tj), node, anchor})[0];
    const double at_head = residualOf(head, {poseBlock(T0.T), node, anchor})[0];
    for (double yaw : {0.03, -1.2, 3.0}) {
      const Pose turn(Quat(rotZ(yaw)), shift);
      EXPECT_NEAR(residualOf(f, {poseBlock(turn * T0.T), poseBlock(turn * Tj), node, anchor})[0], r,
                  1e-9)
          << T0.name << ", " << yaw;
      EXPECT_NEAR(residualOf(head, {poseBlock(turn * T0.T), node, anchor})[0], at_head, 1e-9)
          << T0.name << ", " << yaw;
    }
  }
}

TEST(WindowRangeFactor, AtTheAnchor) {
  const WindowRangeFactor f({1, 0.1, {}}, Vec3::Zero(), Vec3(1, 0, 0));
  const Blocks x = {poseBlock(Pose()),
                    poseBlock(Pose(Quat::Identity(), Vec3(2, 0, 0))),
                    {1, 1, 0, 0, 0},
                    {4, 1, 0, 0}};
  vir_test::expectNullBlocksWork(f, x, "at the anchor");
  Eigen::VectorXd r;
  for (const auto& J : vir_test::analyticJacobians(f, x, &r)) {
    EXPECT_TRUE(J.allFinite());
    EXPECT_EQ(J.leftCols(3).norm(), 0);
  }
}

TEST(HeadRangeFactor, ResidualByHandAndJacobians) {
  // A body that looks along y, antenna 1 m ahead, O turned by another 90 degrees: (-1, 0, 0) from
  // the node (4, 4, 0); anchor at the origin: 5, range 4.5, sigma 0.5: 1.
  const HeadRangeFactor by_hand(plain(4.5, 0.5), Vec3::Zero(), Vec3(1, 0, 0));
  const Pose T(Quat(rotZ(M_PI / 2)), Vec3(9, 9, 9));
  EXPECT_NEAR(residualOf(by_hand, {poseBlock(T), {4, 4, 0, M_PI / 2, 0.3}, {0, 0, 0, 0}})[0], 1,
              1e-12);

  const Vec3 motion(0.3, 0.2, -0.4), lever(-0.1, 0.15, 0.2);
  const std::vector<double> anchor = {12, -13, 4, -0.03};
  for (const vir_test::NamedPose& p : vir_test::poses()) {
    for (const NamedNode& n : difficultNodes()) {
      const Vec3 p_U =
          Vec3(n.x.data()) + rotZ(n.x[3]) * (p.T.q * (std::exp(-n.x[4]) * motion + lever));
      const double expected = (p_U - Vec3(anchor.data())).norm() + anchor[3];
      for (double error : {-1.0, 0.02, 1.0}) {
        const HeadRangeFactor f({expected + error, 0.1, {}}, motion, lever);
        const Blocks x = {poseBlock(p.T), n.x, anchor};
        vir_test::expectJacobians(f, x, p.name + ", " + n.name);
        // The same as a frame of the window at the node's own place.
        const WindowRangeFactor w({expected + error, 0.1, {}}, motion, lever);
        EXPECT_NEAR(residualOf(f, x)[0],
                    residualOf(w, {poseBlock(p.T), poseBlock(p.T), n.x, anchor})[0], 1e-9);
      }
    }
  }
}

}  // namespace
}  // namespace vir::factors
