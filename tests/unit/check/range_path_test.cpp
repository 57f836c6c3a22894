#include "vir/check/range_path.h"

#include <gtest/gtest.h>

#include <cmath>

#include "found.h"
#include "vir/core/random.h"

namespace vir::check {
namespace {

/// A flight about a room with anchors in it; every tenth range is a metre too long.
struct Flight {
  std::map<std::uint64_t, Vec3> anchors{{7, Vec3(4, -3, 2.5)}};
  double bias_m = 0, late_s = 0, unit_m = 1, factor = 1;
  int lengthened = 1;     ///< so many of ten are a metre too long
  double path_scale = 1;  ///< of an odometry
  GivenAnchors given;
  KnownPath path;

  Pose at(double t) const {
    return Pose(expQuat(Vec3(0, 0, 0.4 * t)),
                Vec3(2.5 * std::sin(0.6 * t), 2 * std::cos(0.5 * t), 1.2 + std::sin(0.9 * t)));
  }
  RangePathCheck fly() {
    RangePathCheck check("UWB0");
    Random random(4);
    const Vec3 antenna(0.1, 0, 0.05);
    for (int i = 0; i < 16000; ++i) {
      const double t = 0.005 * i;
      Pose T = at(t);
      if (i % 10 == 5) {
        for (const auto& [id, p] : anchors) {
          Range r;
          r.t = fromSeconds(t + late_s);
          r.anchor = id;
          r.p_B_U = antenna;
          r.range_m = (factor * (p - T * antenna).norm() + bias_m + 0.05 * random.normal() +
                       (i / 10 % 10 < lengthened ? 1.0 : 0)) /
                      unit_m;
          check.add(r);
        }
      }
      T.p *= path_scale;
      path.add({fromSeconds(t), T});
    }
    return check;
  }
  std::vector<Finding> findings() {
    const RangePathCheck check = fly();
    return check.againstTruth(path, given);
  }
};

bool says(const std::vector<Finding>& findings, const std::string& kind, const std::string& words) {
  for (const Finding& f : findings) {
    const std::string all = f.what + " | " + f.evidence + " | " + f.remedy;
    if (f.kind == kind && all.find(words) != std::string::npos) return true;
  }
  return false;
}

TEST(RangePath, WithoutAFaultThereIsANote) {
  Flight flight;
  auto findings = flight.findings();
  EXPECT_EQ(seriousKinds(findings), Kinds{});
  EXPECT_EQ(findings.size(), 2u);  // the constant error, and a tenth without line of sight
  flight.given.truth = flight.anchors;
  EXPECT_EQ(seriousKinds(flight.findings()), Kinds{});
}

TEST(RangePath, AConstantErrorIsFound) {
  for (const double bias : {0.6, -0.4, 1.2}) {
    Flight flight;
    flight.bias_m = bias;
    EXPECT_EQ(seriousKinds(flight.findings()), Kinds{"range_bias"}) << bias;
    flight.given.truth = flight.anchors;
    const auto findings = flight.findings();
    EXPECT_EQ(seriousKinds(findings), Kinds{"range_bias"}) << bias;
    EXPECT_TRUE(says(findings, "range_bias", bias > 0 ? "too long" : "too short"));
  }
}

TEST(RangePath, RangesThatAreWrongInProportionAreNoConstantError) {
  for (const double factor : {1.05, 0.96}) {
    Flight flight;
    flight.anchors = {{7, Vec3(4, -3, 2.5)}, {8, Vec3(-6, 3, 0.5)}};
    flight.factor = factor;
    const auto findings = flight.findings();
    ASSERT_EQ(seriousKinds(findings), Kinds{"range_scale"}) << factor;
    EXPECT_TRUE(says(findings, "range_scale", factor > 1 ? "too long by" : "too short by"));
    const std::string remedy = findings.front().remedy;
    EXPECT_NEAR(std::stod(remedy.substr(remedy.find('=') + 1)), 1 / factor, 0.005);
    flight.given.truth = flight.anchors;
    EXPECT_EQ(seriousKinds(flight.findings()), Kinds{"range_scale"}) << factor;
    flight.bias_m = 0.6;
    EXPECT_EQ(seriousKinds(flight.findings()), (Kinds{"range_scale", "range_bias", "range_bias"}));
  }
}

TEST(RangePath, AnchorsThatAreOffEachInItsOwnWayHaveNoCommonFactor) {
  Flight flight;
  flight.anchors = {{7, Vec3(4, -3, 2.5)}, {8, Vec3(-6, 3, 0.5)}};
  flight.bias_m = 0.5;
  flight.given.truth = flight.anchors;
  flight.given.truth[7] += Vec3(0.3, 0, 0);
  for (const Finding& f : flight.findings()) EXPECT_NE(f.kind, "range_scale") << f.evidence;
}

TEST(RangePath, RangesWithoutLineOfSightAreCounted) {
  Flight flight;
  auto findings = flight.findings();
  EXPECT_TRUE(says(findings, "range_lengthened", "anchor 7: 10 % of the ranges are far too long"));
  EXPECT_EQ(seriousKinds(findings), Kinds{});
  flight.lengthened = 3;
  findings = flight.findings();
  EXPECT_EQ(seriousKinds(findings), Kinds{"range_lengthened"});
  EXPECT_TRUE(says(findings, "range_lengthened", "30 % of the ranges"));
  flight.lengthened = 0;
  EXPECT_FALSE(says(flight.findings(), "range_lengthened", ""));
}

TEST(RangePath, TheFitIsRight) {
  Flight flight;
  flight.bias_m = 0.6;
  flight.late_s = 0.3;
  flight.fly();
  std::vector<Range> ranges;
  for (int i = 100; i < 15000; i += 10) {
    const double t = 0.005 * i;
    Range r;
    r.t = fromSeconds(t + 0.3);
    r.range_m = (Vec3(4, -3, 2.5) - flight.at(t).p).norm() + 0.6;
    ranges.push_back(r);
  }
  const AnchorFit fit = fitAnchor(flight.path, ranges);
  ASSERT_TRUE(fit.found);
  EXPECT_NEAR(fit.bias_m, 0.6, 0.01);
  EXPECT_NEAR(fit.offset_s, -0.3, 0.002);
  EXPECT_LT((fit.p_W - Vec3(4, -3, 2.5)).norm(), 0.01);
  const AnchorFit held = fitAnchor(flight.path, ranges, 1, Vec3(4, -3, 2.5));
  EXPECT_NEAR(held.bias_m, 0.6, 0.01);
  EXPECT_EQ(held.p_W, Vec3(4, -3, 2.5));
}

TEST(RangePath, AnotherUnitIsFound) {
  for (const auto& [unit_m, kind] :
       {std::pair{0.3048, "ranges_in_ft"}, {0.0254, "ranges_in_in"}, {0.01, "ranges_in_cm"}}) {
    Flight flight;
    flight.unit_m = unit_m;
    EXPECT_EQ(seriousKinds(flight.findings()), Kinds{kind});
    flight.given.truth = flight.anchors;
    EXPECT_EQ(seriousKinds(flight.findings()), Kinds{kind});
  }
}

TEST(RangePath, StampsThatAreOffAreFound) {
  for (const double late : {0.3, -0.2, 1.5}) {
    Flight flight;
    flight.late_s = late;
    const auto findings = flight.findings();
    EXPECT_EQ(seriousKinds(findings), Kinds{"range_time_offset"}) << late;
    EXPECT_TRUE(says(findings, "range_time_offset", late > 0 ? "too late" : "too early"));
  }
}

TEST(RangePath, SeveralFaultsAreToldApart) {
  Flight flight;
  flight.late_s = 0.3;
  flight.bias_m = 1.2;
  flight.unit_m = 0.3048;
  EXPECT_EQ(seriousKinds(flight.findings()),
            (Kinds{"ranges_in_ft", "range_time_offset", "range_bias"}));
}

TEST(RangePath, AWrongPlaceIsFound) {
  Flight flight;
  flight.anchors = {{7, Vec3(4, -3, 2.5)}, {8, Vec3(-4, 3, 0.5)}, {9, Vec3(-3, -4, 2)}};
  flight.given.truth = flight.anchors;
  flight.given.truth[8] += Vec3(0.8, 0, 0);
  auto findings = flight.findings();
  EXPECT_EQ(seriousKinds(findings), Kinds{"anchor_place"});
  EXPECT_TRUE(says(findings, "anchor_place", "anchor 8 is not where"));
  flight.given.truth = flight.anchors;
  std::swap(flight.given.truth[7], flight.given.truth[9]);
  findings = flight.findings();
  EXPECT_EQ(seriousKinds(findings), (Kinds{"anchor_place", "anchor_place"}));
  EXPECT_TRUE(says(findings, "anchor_place", "but where it has anchor 9"));
  for (auto& [id, p] : flight.given.truth) p += Vec3(3, 1, 0);
  findings = flight.findings();
  EXPECT_EQ(seriousKinds(findings), Kinds{"anchor_place"});
  EXPECT_TRUE(says(findings, "anchor_place", "none of the anchors"));
}

TEST(RangePath, ASurveyInAFrameOfItsOwnIsHeldAgainstThePath) {
  Flight flight;
  flight.anchors = {
      {1, Vec3(4, -3, 2.5)}, {2, Vec3(-4, 3, 0.5)}, {3, Vec3(-3, -4, 2)}, {4, Vec3(4, 4, 1)}};
  for (const auto& [id, p] : flight.anchors) {
    flight.given.survey.push_back({id, expQuat(Vec3(0, 0, 1)) * p + Vec3(100, 50, 3), 0.05});
  }
  EXPECT_EQ(seriousKinds(flight.findings()), Kinds{});
  flight.given.survey[1].p_S.x() += 1.5;
  const auto findings = flight.findings();
  EXPECT_EQ(seriousKinds(findings), Kinds{"anchor_place"});
  EXPECT_TRUE(says(findings, "anchor_place", "anchor 2"));
}

TEST(RangePath, AnOdometryTellsUnitAndClock) {
  Flight flight;
  flight.path_scale = 1.15;
  EXPECT_EQ(seriousKinds(flight.fly().againstOdometry(flight.path)), Kinds{});
  flight.unit_m = 0.3048;
  EXPECT_EQ(seriousKinds(flight.fly().againstOdometry(flight.path)), Kinds{"ranges_in_ft"});
}

TEST(RangePath, RangesThatFitNothingAreSaid) {
  Flight flight;
  RangePathCheck check("UWB0");
  flight.fly();
  Random random(5);
  for (int i = 0; i < 1000; ++i) {
    Range r;
    r.t = fromSeconds(0.05 * i + 1);
    r.range_m = 5 + 20 * random.uniform();
    check.add(r);
  }
  EXPECT_EQ(seriousKinds(check.againstTruth(flight.path, {})), Kinds{"range_misfit"});
}

TEST(RangePath, AStraightLineAccusesNobody) {
  KnownPath path;
  RangePathCheck check("UWB0");
  Random random(6);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 p(0.005 * i, 0, 0);
    path.add({fromSeconds(0.02 * i), Pose(Quat::Identity(), p)});
    Range r;
    r.t = fromSeconds(0.02 * i + 0.001);
    r.range_m = (Vec3(2, 3, 0) - p).norm() + 0.05 * random.normal();
    check.add(r);
  }
  EXPECT_EQ(seriousKinds(check.againstTruth(path, {})), Kinds{});
  EXPECT_FALSE(fitAnchor(path, {}).found);
  // A path of one pose, and none.
  EXPECT_EQ(seriousKinds(check.againstTruth(KnownPath(), {})), Kinds{});
  EXPECT_EQ(seriousKinds(check.againstOdometry(KnownPath())), Kinds{});
}

}  // namespace
}  // namespace vir::check
