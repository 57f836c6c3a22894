#include "vir/team/transform_graph.h"

#include <gtest/gtest.h>

#include "vir_test_noise.h"

namespace vir::team {
namespace {

struct World {
  std::string name;
  WorldTransform T_W;  // to a common frame
};

const std::vector<World> kWorlds = {
    {"A", {0.4, Vec3(1, 2, 0)}}, {"B", {-1.2, Vec3(-3, 5, 1)}}, {"C", {2.9, Vec3(7, -2, 0.5)}}};

TransformEdge edge(std::size_t from, std::size_t to, const Eigen::Vector4d& error,
                   double sigma = 0.05) {
  TransformEdge e;
  e.from = kWorlds[from].name;
  e.to = kWorlds[to].name;
  e.T_to_from = kWorlds[to].T_W.inverse() * kWorlds[from].T_W;
  e.T_to_from.yaw_rad += error[0];
  e.T_to_from.t_m += error.tail<3>();
  e.covariance = sigma * sigma * Eigen::Matrix4d::Identity();
  return e;
}

TEST(TransformGraph, ALoopOfTrueTransformsCloses) {
  const Eigen::Vector4d none = Eigen::Vector4d::Zero();
  // The last one is given the other way round.
  const auto loops = checkLoops({edge(1, 0, none), edge(2, 1, none), edge(2, 0, none)});
  ASSERT_EQ(loops.size(), 1u);
  EXPECT_EQ(loops[0].robots, "A B C");
  EXPECT_NEAR(loops[0].error.norm(), 0, 1e-12);
  EXPECT_TRUE(loops[0].consistent);
}

TEST(TransformGraph, AWrongOneIsNoticed) {
  const Eigen::Vector4d none = Eigen::Vector4d::Zero();
  const auto loops =
      checkLoops({edge(1, 0, none), edge(2, 1, Eigen::Vector4d(1, 3, 0, 0)), edge(2, 0, none)});
  ASSERT_EQ(loops.size(), 1u);
  EXPECT_FALSE(loops[0].consistent);
  EXPECT_NEAR(std::abs(loops[0].error[0]), 1, 1e-9);
}

TEST(TransformGraph, ChiSquareOfLoopsIsThatOfFourDegreesOfFreedom) {
  test::Noise noise(1);
  const auto draw = [&] {
    Eigen::Vector4d e;
    for (int i = 0; i < 4; ++i) e[i] = 0.01 * noise.normal();
    return e;
  };
  double sum = 0;
  for (int i = 0; i < 500; ++i) {
    sum += checkLoops(
               {edge(0, 1, draw(), 0.01), edge(2, 1, draw(), 0.01), edge(2, 0, draw(), 0.01)})[0]
               .chi2;
  }
  EXPECT_NEAR(sum / 500, 4, 0.5);
}

TEST(TransformGraph, CommonFrameGoesTheMostCertainWay) {
  const Eigen::Vector4d none = Eigen::Vector4d::Zero(), wrong(0, 1, 0, 0);
  const auto frame =
      commonFrame("A", {edge(1, 0, none, 0.01), edge(2, 1, none, 0.01), edge(2, 0, wrong, 1)});
  ASSERT_EQ(frame.size(), 3u);
  for (const World& w : kWorlds) {
    const WorldTransform expected = kWorlds[0].T_W.inverse() * w.T_W;
    EXPECT_NEAR((frame.at(w.name).t_m - expected.t_m).norm(), 0, 1e-9) << w.name;
    EXPECT_NEAR(wrapAngle(frame.at(w.name).yaw_rad - expected.yaw_rad), 0, 1e-9);
  }
}

TEST(TransformGraph, WhoIsNotTiedIsLeftOut) {
  const auto frame = commonFrame("A", {edge(2, 1, Eigen::Vector4d::Zero())});
  EXPECT_EQ(frame.size(), 1u);
  EXPECT_EQ(frame.count("A"), 1u);
}

}  // namespace
}  // namespace vir::team
