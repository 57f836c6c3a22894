/// Anchors that a map and a run in it both have found.
#include "map_anchors.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

namespace vir::mission {
namespace {

Anchor anchorAt(std::uint64_t id, const Vec3& p, const Vec3& sigma) {
  Anchor a;
  a.id = id;
  a.has_position = true;
  a.p_W = p;
  a.covariance = sigma.cwiseAbs2().asDiagonal();
  a.state = AnchorState::estimated;
  return a;
}

struct Told {
  std::vector<std::string> warnings;
  LogSink sink() {
    return [this](LogLevel level, const std::string& text) {
      if (level == LogLevel::warning) warnings.push_back(text);
    };
  }
};

TEST(MapAnchors, AWorseRunTakesNothingAway) {
  Told told;
  const Anchor before = anchorAt(7, Vec3(1, 2, 3), Vec3(0.020, 0.029, 0.032));
  const Anchor now = anchorAt(7, Vec3(1.03, 1.98, 2.9), Vec3(0.040, 0.034, 0.118));
  const auto joined = joinAnchors({before}, {now}, told.sink());
  ASSERT_EQ(joined.size(), 1u);
  EXPECT_LE(joined[0].covariance.trace(), before.covariance.trace());
  EXPECT_LT((joined[0].p_W - before.p_W).norm(), 0.01);
  // The other way round it is the run's that counts.
  const auto better = joinAnchors({now}, {before}, told.sink());
  EXPECT_LT((better[0].p_W - before.p_W).norm(), 0.01);
  EXPECT_TRUE(told.warnings.empty());
}

/// Each knows what the other does not.
TEST(MapAnchors, BothTogetherKnowMore) {
  const Anchor x = anchorAt(7, Vec3(1, 2.1, 3), Vec3(0.01, 0.2, 0.05));
  const Anchor y = anchorAt(7, Vec3(1.1, 2, 3), Vec3(0.2, 0.01, 0.05));
  const Anchor both = joinAnchors({x}, {y}, {}).front();
  EXPECT_LT((both.p_W - Vec3(1, 2, 3)).norm(), 0.002);
  // Weighed alike, as they know as much: half of the information of each.
  const double across = 2 / (1 / (0.01 * 0.01) + 1 / (0.2 * 0.2));
  const Mat3 expected = Vec3(across, across, 0.05 * 0.05).asDiagonal();
  EXPECT_LT((both.covariance - expected).norm(), 1e-9);
  EXPECT_EQ(both.covariance, both.covariance.transpose());
}

/// A wall beside it falsifies every run's ranges in the same way.
TEST(MapAnchors, OftenIsNotCertain) {
  const Vec3 sigma(0.03, 0.04, 0.05);
  std::vector<Anchor> known{anchorAt(7, Vec3(1, 2, 3), sigma)};
  for (int i = 0; i < 20; ++i) known = joinAnchors(known, {anchorAt(7, Vec3(1, 2, 3), sigma)}, {});
  EXPECT_NEAR(known[0].covariance.trace(), sigma.squaredNorm(), 1e-9);
}

TEST(MapAnchors, AContradictionKeepsTheMaps) {
  Told told;
  const Anchor before = anchorAt(7, Vec3(1, 2, 3), Vec3(0.1, 0.1, 0.1));
  const Anchor now = anchorAt(7, Vec3(3, 2, 3), Vec3(0.01, 0.01, 0.01));
  const auto joined = joinAnchors({before}, {now}, told.sink());
  EXPECT_EQ(joined[0].p_W, before.p_W);
  EXPECT_EQ(joined[0].covariance, before.covariance);
  ASSERT_EQ(told.warnings.size(), 1u);
  EXPECT_NE(told.warnings[0].find("anchor 7 is 2.00 m"), std::string::npos) << told.warnings[0];
}

TEST(MapAnchors, WhatOnlyOneKnowsIsItsOwn) {
  Told told;
  const Vec3 sigma(0.1, 0.1, 0.1);
  Anchor open = anchorAt(1, Vec3(9, 9, 9), sigma);
  open.state = AnchorState::mirror_open;
  const Anchor settled = anchorAt(1, Vec3(1, 1, 1), sigma);
  EXPECT_EQ(joinAnchors({settled}, {open}, told.sink())[0].p_W, settled.p_W);
  EXPECT_EQ(joinAnchors({open}, {settled}, told.sink())[0].p_W, settled.p_W);
  const auto all = joinAnchors({anchorAt(5, Vec3(5, 0, 0), sigma)},
                               {Anchor(), anchorAt(2, Vec3(2, 0, 0), sigma)}, told.sink());
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0].id, 2u);
  EXPECT_EQ(all[1].id, 5u);
  // One given in the run has no covariance that could be weighed.
  const Anchor given = anchorAt(1, Vec3(1.05, 1, 1), Vec3(0, 0, 0));
  EXPECT_EQ(joinAnchors({settled}, {given}, told.sink())[0].p_W, given.p_W);
  EXPECT_TRUE(told.warnings.empty());
}

}  // namespace
}  // namespace vir::mission
