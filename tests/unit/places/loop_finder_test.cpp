/// When a second visit is believed, and when not.
#include "vir/places/loop_finder.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "made_places.h"

namespace {

using namespace vir;
using places::LoopFinder;
using places::RelativePrior;
using vir_test::KeyframePtr;
using vir_test::MadeWorld;
using vir_test::standing;

Pose along(double x) { return standing(Vec3(x, 0.02 * x, 0), 0.1 * x); }

std::string decisionOf(const LoopFinder& finder, std::uint64_t older) {
  for (const auto& a : finder.attempts()) {
    if (a.older == older) return a.decision;
  }
  return finder.attempts().empty() ? "no attempt" : finder.attempts().front().decision;
}

class Visits : public testing::Test {
 protected:
  Visits() : world_(900, 2), finder_({}, {}, {}) {}
  std::vector<Loop> see(double s, const Pose& T, const LoopFinder::Prior& prior = {}) {
    return finder_.add(world_.see(next_++, s, T), prior);
  }
  /// The path is known to 0.3 m.
  static LoopFinder::Prior exactPath() { return path(0.3); }
  static LoopFinder::Prior vaguePath() { return path(3); }
  static LoopFinder::Prior path(double sigma) {
    return [sigma](const PlaceKeyframe& a, const PlaceKeyframe& b) {
      RelativePrior p;
      p.T_older_newer = a.T_W_B.inverse() * b.T_W_B;
      p.covariance *= sigma * sigma;
      return std::optional<RelativePrior>(p);
    };
  }
  /// Ids 0 to 3, a metre along the way.
  void firstVisit() {
    for (int k = 0; k < 4; ++k) EXPECT_TRUE(see(0.5 * k, along(0.3 * k)).empty());
  }
  MadeWorld world_;
  LoopFinder finder_;
  std::uint64_t next_ = 0;
};

TEST_F(Visits, ALoopIsBelievedWhenASecondKeyframeAgrees) {
  firstVisit();
  EXPECT_TRUE(see(60, along(0.05), exactPath()).empty());
  ASSERT_FALSE(finder_.attempts().empty());
  EXPECT_EQ(decisionOf(finder_, finder_.attempts().front().older), "waits for another");
  const std::vector<Loop> both = see(60.5, along(0.35), exactPath());
  ASSERT_EQ(both.size(), 2U);
  EXPECT_EQ(both[0].newer, 4U);
  EXPECT_EQ(both[1].newer, 5U);
  EXPECT_LT(both[0].older, 4U);
  for (const Loop& l : both) {
    const Pose older = along(0.3 * static_cast<double>(l.older));
    const Pose truth = older.inverse() * along(l.newer == 4 ? 0.05 : 0.35);
    EXPECT_LT((l.T_older_newer.p - truth.p).norm(), 0.05);
  }
  // The next one is believed at once, and nobody is told twice.
  const std::vector<Loop> third = see(61, along(0.65), exactPath());
  ASSERT_EQ(third.size(), 1U);
  EXPECT_EQ(third[0].newer, 6U);
  EXPECT_EQ(decisionOf(finder_, third[0].older), "accepted");
}

TEST_F(Visits, LookingTwiceFromOneSpotIsOneLook) {
  firstVisit();
  for (int k = 0; k < 5; ++k) EXPECT_TRUE(see(60 + 0.5 * k, along(0.05)).empty());
}

TEST_F(Visits, WhatWasJustSeenIsNoSecondVisit) {
  firstVisit();
  EXPECT_TRUE(see(4, along(0.05)).empty());
  EXPECT_TRUE(finder_.attempts().empty());
}

TEST_F(Visits, AKeyframeOfLongAgoIsNoSecondOpinion) {
  firstVisit();
  EXPECT_TRUE(see(60, along(0.05), exactPath()).empty());
  EXPECT_TRUE(see(70, along(0.35), exactPath()).empty());
  EXPECT_EQ(see(70.5, along(0.65), exactPath()).size(), 2U);
}

TEST_F(Visits, WhereNothingElseIsKnownThreeMustAgree) {
  firstVisit();
  EXPECT_TRUE(see(60, along(0.05)).empty());
  EXPECT_TRUE(see(60.5, along(0.35)).empty());
  EXPECT_EQ(see(61, along(0.65)).size(), 3U);
}

/// Its image, all together, shows less than `min_alike` of what must be in view: a place that only
/// has corners like it.
TEST_F(Visits, APlaceThatShowsSomethingElseBetweenItsCornersIsUnlike) {
  firstVisit();
  int asked = 0, alike_of_100 = 60;
  const LoopFinder::Compare compare = [&](const std::vector<places::ExpectedPoint>& expected) {
    ++asked;
    std::vector<int> bits;
    for (std::size_t k = 0; k < expected.size(); ++k) {
      bits.push_back(static_cast<int>(100 * k / expected.size()) < alike_of_100 ? 10 : 120);
    }
    return bits;
  };
  const auto look = [&](double s, double x, const LoopFinder::Prior& prior = {}) {
    return finder_.add(world_.see(next_++, s, along(x)), prior, {}, compare);
  };
  EXPECT_TRUE(look(60, 0.05).empty());
  EXPECT_TRUE(look(60.5, 0.35).empty());
  EXPECT_TRUE(look(61, 0.65).empty());
  EXPECT_EQ(decisionOf(finder_, finder_.attempts().front().older), "unlike");
  EXPECT_EQ(asked, 3);
  alike_of_100 = 90;  // (3 x 60 + 90) / 4 = 67.5
  EXPECT_EQ(look(61.5, 0.8).size(), 4U);
  // Where the path says where the place is nobody is asked.
  asked = 0;
  EXPECT_EQ(look(100, 0.05, exactPath()).size(), 0U);
  EXPECT_EQ(look(100.5, 0.35, exactPath()).size(), 2U);
  EXPECT_EQ(asked, 0);
}

/// One that shows less than half is not counted with the others.
TEST_F(Visits, AnImageThatShowsLittleOfThePlaceHasNoVoice) {
  firstVisit();
  int bits_of_next = 10;
  const LoopFinder::Compare compare = [&](const std::vector<places::ExpectedPoint>& expected) {
    std::vector<int> bits(expected.size(), bits_of_next);
    std::fill(bits.begin(), bits.begin() + static_cast<long>(expected.size()) * 2 / 5, 10);
    return bits;
  };
  const auto look = [&](double s, double x) {
    return finder_.add(world_.see(next_++, s, along(x)), {}, {}, compare);
  };
  EXPECT_TRUE(look(60, 0.05).empty());
  bits_of_next = 120;
  EXPECT_TRUE(look(60.5, 0.35).empty());
  EXPECT_EQ(decisionOf(finder_, finder_.attempts().front().older), "unlike");
  bits_of_next = 10;
  EXPECT_TRUE(look(61, 0.65).empty());
  EXPECT_EQ(look(61.5, 0.8).size(), 3U);
}

/// Where the image is compared corners do that would be too few alone.
TEST_F(Visits, FewCornersAreEnoughWhereTheImageIsCompared) {
  places::VerifyOptions o;
  o.min_inliers_known = o.min_inliers_alone = 1000;
  const LoopFinder::Compare alike = [](const std::vector<places::ExpectedPoint>& expected) {
    return std::vector<int>(expected.size(), 10);
  };
  for (const bool compares : {false, true}) {
    finder_ = LoopFinder({}, {}, o);
    next_ = 0;
    firstVisit();
    const auto look = [&](double s, double x) {
      return finder_.add(world_.see(next_++, s, along(x)), {}, {},
                         compares ? alike : LoopFinder::Compare());
    };
    for (int k = 0; k < 3; ++k) EXPECT_TRUE(look(60 + 0.5 * k, 0.05 + 0.3 * k).empty());
    EXPECT_EQ(look(61.5, 0.8).size(), compares ? 4U : 0U);
    EXPECT_EQ(decisionOf(finder_, finder_.attempts().front().older),
              compares ? "accepted" : "few inliers");
  }
}

/// A wall: nothing of what must be in view is in the image.
TEST_F(Visits, AnImageThatShowsNothingOfThePlaceTellsOfNone) {
  firstVisit();
  const LoopFinder::Compare nothing = [](const std::vector<places::ExpectedPoint>& expected) {
    return std::vector<int>(expected.size(), -1);
  };
  for (int k = 0; k < 3; ++k) {
    EXPECT_TRUE(
        finder_.add(world_.see(next_++, 60 + 0.5 * k, along(0.05 + 0.3 * k)), {}, {}, nothing)
            .empty());
  }
  EXPECT_EQ(decisionOf(finder_, finder_.attempts().front().older), "unlike");
}

/// The map was recorded at the very same times (the same recording, played again).
TEST_F(Visits, AMapThatWasLoadedIsNeverRecent) {
  for (int k = 0; k < 4; ++k) finder_.remember(world_.see(next_++, 0.5 * k, along(0.3 * k)));
  EXPECT_TRUE(see(0, along(0.05)).empty());
  EXPECT_TRUE(see(0.5, along(0.35)).empty());
  EXPECT_EQ(see(1, along(0.65)).size(), 3U);
}

/// The path says that the robot went on by half a metre, the two loops that it stayed.
TEST_F(Visits, LoopsThatContradictThePathAreNotBelieved) {
  firstVisit();
  EXPECT_TRUE(see(60, along(0.05), vaguePath()).empty());
  const Pose believed = along(0.35) * Pose(Quat::Identity(), Vec3(0.5, 0.5, 0));
  EXPECT_TRUE(finder_.add(world_.see(next_++, 60.5, along(0.35), believed), vaguePath()).empty());
  EXPECT_EQ(decisionOf(finder_, finder_.attempts().front().older), "waits for another");
}

/// Two places that look the same to the last point, 20 m apart in the map.
class Twins : public Visits {
 protected:
  void visitBoth() {
    firstVisit();
    for (int k = 0; k < 4; ++k) {
      const Pose there(along(0.3 * k).q, along(0.3 * k).p + Vec3(20, 0, 0));
      finder_.add(world_.see(next_++, 40 + 0.5 * k, along(0.3 * k), there), exactPath());
    }
  }
};

TEST_F(Twins, WithoutOdometryNeitherIsBelieved) {
  visitBoth();
  EXPECT_TRUE(see(100, along(0.05)).empty());
  EXPECT_TRUE(see(100.5, along(0.35)).empty());
  EXPECT_TRUE(see(101, along(0.65)).empty());
  bool ambiguous = false;
  for (const auto& a : finder_.attempts()) ambiguous = ambiguous || a.decision == "ambiguous";
  EXPECT_TRUE(ambiguous);
}

TEST_F(Twins, OdometryTellsThemApart) {
  visitBoth();
  EXPECT_TRUE(see(100, along(0.05), exactPath()).empty());
  const std::vector<Loop> loops = see(100.5, along(0.35), exactPath());
  ASSERT_EQ(loops.size(), 2U);
  for (const Loop& l : loops) EXPECT_LT(l.older, 4U);
}

/// The twin was never seen before: only odometry knows.
TEST_F(Twins, OdometryRefusesTheTwin) {
  firstVisit();
  const auto shifted = [&](double s, double x) {
    const Pose there(along(x).q, along(x).p + Vec3(20, 0, 0));
    return finder_.add(world_.see(next_++, s, along(x), there), exactPath());
  };
  EXPECT_TRUE(shifted(60, 0.05).empty());
  EXPECT_TRUE(shifted(60.5, 0.35).empty());
  ASSERT_FALSE(finder_.attempts().empty());
  EXPECT_EQ(finder_.attempts().front().decision, "against odometry and ranges");
}

TEST(LoopFinder, RefusesOptionsThatAreNone) {
  places::LoopFinderOptions o;
  o.agreeing = 0;
  EXPECT_THROW(LoopFinder(o, {}, {}), std::invalid_argument);
  places::VerifyOptions v;
  v.ratio = 2;
  EXPECT_THROW(LoopFinder({}, {}, v), std::invalid_argument);
}

}  // namespace
