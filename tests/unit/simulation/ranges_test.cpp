/// Simulated ranges have the errors that were asked for.
#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "made_motions.h"
#include "vir/simulation/simulate_ranges.h"

namespace {

using namespace vir;

vir::simulation::RangeSimulationOptions perfect() {
  vir::simulation::RangeSimulationOptions o;
  o.anchor_m = {5, 2, 1};
  o.sigma_m = 0;
  return o;
}

struct Errors {
  double mean = 0, deviation = 0, correlation = 0;  ///< from one to the next
};

Errors errorsOf(const std::vector<vir::simulation::SimulatedRange>& ranges) {
  Errors e;
  double square = 0, product = 0;
  const auto n = static_cast<double>(ranges.size());
  for (const vir::simulation::SimulatedRange& r : ranges) e.mean += (r.range_m - r.true_m) / n;
  for (std::size_t k = 0; k < ranges.size(); ++k) {
    const double x = ranges[k].range_m - ranges[k].true_m - e.mean;
    square += x * x;
    if (k > 0) product += x * (ranges[k - 1].range_m - ranges[k - 1].true_m - e.mean);
  }
  e.deviation = std::sqrt(square / n);
  e.correlation = product / square;
  return e;
}

TEST(SimulatedRanges, WithoutErrorsMeasureFromTheAntenna) {
  const auto motion = vir_test::briskFlight();
  vir::simulation::RangeSimulationOptions o = perfect();
  o.lever_arm_m = {0.1, -0.2, 0.3};
  const auto ranges = vir::simulation::simulateRanges(*motion, o);
  ASSERT_NEAR(static_cast<double>(ranges.size()), 20 * motion->duration(), 2);
  TimeNs last = 0;
  for (const vir::simulation::SimulatedRange& r : ranges) {
    EXPECT_GT(r.t, last);
    last = r.t;
    const Vec3 antenna = motion->poseAt(r.t) * Vec3(0.1, -0.2, 0.3);
    EXPECT_NEAR(r.range_m, (antenna - Vec3(5, 2, 1)).norm(), 1e-12);
    EXPECT_EQ(r.anchor, 0);
  }
}

TEST(SimulatedRanges, WhiteNoiseAndBias) {
  vir::simulation::RangeSimulationOptions o = perfect();
  o.sigma_m = 0.05;
  o.bias_m = 0.2;
  const Errors e = errorsOf(vir::simulation::simulateRanges(*vir_test::standing(500), o));
  EXPECT_NEAR(e.mean, 0.2, 0.002);
  EXPECT_NEAR(e.deviation, 0.05, 0.002);
  EXPECT_NEAR(e.correlation, 0, 0.04);
}

TEST(SimulatedRanges, CorrelatedNoise) {
  vir::simulation::RangeSimulationOptions o = perfect();
  o.correlated_sigma_m = 0.04;
  o.correlated_s = 0.5;
  const Errors e = errorsOf(vir::simulation::simulateRanges(*vir_test::standing(1000), o));
  EXPECT_NEAR(e.deviation, 0.04, 0.003);
  EXPECT_NEAR(e.correlation, std::exp(-0.05 / 0.5), 0.01);
}

TEST(SimulatedRanges, BiasFollowsTheDistance) {
  vir::simulation::RangeSimulationOptions o = perfect();
  o.bias_curve = {0, 0, 4, 0.4, 8, 0};
  for (const vir::simulation::SimulatedRange& r :
       vir::simulation::simulateRanges(*vir_test::briskFlight(), o)) {
    const double x = r.true_m;
    const double expected = x < 4 ? 0.1 * x : std::max(0.0, 0.8 - 0.1 * x);
    EXPECT_NEAR(r.range_m - x, expected, 1e-12);
  }
}

TEST(SimulatedRanges, WithoutLineOfSightTheyAreLonger) {
  for (const double burst : {0.0, 2.0}) {
    vir::simulation::RangeSimulationOptions o = perfect();
    o.nlos_share = 0.1;
    o.nlos_burst_s = burst;
    const auto ranges = vir::simulation::simulateRanges(*vir_test::standing(2000), o);
    double blocked = 0, stretches = 0;
    bool before = false;
    for (const vir::simulation::SimulatedRange& r : ranges) {
      const double excess = r.range_m - r.true_m;
      if (r.line_of_sight) {
        EXPECT_NEAR(excess, 0, 1e-12);
      } else {
        EXPECT_GE(excess, 0.3);
        EXPECT_LE(excess, 1.8);
      }
      blocked += r.line_of_sight ? 0 : 1;
      if (!r.line_of_sight && !before) ++stretches;
      before = !r.line_of_sight;
    }
    EXPECT_NEAR(blocked / static_cast<double>(ranges.size()), 0.1, burst > 0 ? 0.025 : 0.01);
    if (burst > 0) {
      EXPECT_NEAR(blocked / stretches / 20, burst, 0.5);
    }
  }
}

TEST(SimulatedRanges, OutagesLossesAndReach) {
  const auto motion = vir_test::briskFlight();
  vir::simulation::RangeSimulationOptions o = perfect();
  o.outage_s = {10, 20, 30, 35};
  o.max_distance_m = 6;
  for (const vir::simulation::SimulatedRange& r : vir::simulation::simulateRanges(*motion, o)) {
    const double s = toSeconds(r.t - motion->begin());
    EXPECT_FALSE((s >= 10 && s < 20) || (s >= 30 && s < 35)) << s;
    EXPECT_LE(r.true_m, 6);
  }
  vir::simulation::RangeSimulationOptions lossy = perfect();
  const auto all = vir::simulation::simulateRanges(*motion, lossy);
  lossy.dropped_share = 0.3;
  const auto some = vir::simulation::simulateRanges(*motion, lossy);
  EXPECT_NEAR(static_cast<double>(some.size()), 0.7 * static_cast<double>(all.size()), 60);
}

TEST(SimulatedRanges, AnAnchorIsMoved) {
  const auto motion = vir_test::standing(20);
  vir::simulation::RangeSimulationOptions o = perfect();
  o.jump = {0, 10, 9, 9, 9};
  for (const vir::simulation::SimulatedRange& r : vir::simulation::simulateRanges(*motion, o)) {
    const Vec3 anchor = toSeconds(r.t - motion->begin()) < 10 ? Vec3(5, 2, 1) : Vec3(9, 9, 9);
    EXPECT_NEAR(r.range_m, (motion->poseAt(r.t).p - anchor).norm(), 1e-12);
  }
}

TEST(SimulatedRanges, SeveralAnchorsInTimeOrderWithTheirIds) {
  vir::simulation::RangeSimulationOptions o = perfect();
  o.anchor_m = {5, 2, 1, -3, 0, 2};
  o.anchor_id = {7, 3};
  const auto ranges = vir::simulation::simulateRanges(*vir_test::standing(10), o);
  long seven = 0, three = 0;
  for (std::size_t k = 0; k < ranges.size(); ++k) {
    if (k > 0) {
      EXPECT_GE(ranges[k].t, ranges[k - 1].t);
    }
    seven += ranges[k].anchor == 7;
    three += ranges[k].anchor == 3;
  }
  EXPECT_EQ(seven, 200);
  EXPECT_EQ(three, 200);
}

TEST(SimulatedRanges, OneErrorLeavesTheOthersAsTheyWere) {
  const auto motion = vir_test::standing(10);
  vir::simulation::RangeSimulationOptions o = perfect();
  o.sigma_m = 0.05;
  const auto a = vir::simulation::simulateRanges(*motion, o);
  o.nlos_share = 0.2;
  const auto b = vir::simulation::simulateRanges(*motion, o);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k) {
    EXPECT_EQ(a[k].t, b[k].t);
    if (b[k].line_of_sight) {
      EXPECT_EQ(a[k].range_m, b[k].range_m);
    }
  }
}

TEST(SimulatedRanges, RefuseListsOfTheWrongLength) {
  const auto motion = vir_test::standing(2);
  for (int k = 0; k < 6; ++k) {
    vir::simulation::RangeSimulationOptions o = perfect();
    if (k == 0) o.anchor_m.pop_back();
    if (k == 1) o.anchor_id = {1, 2};
    if (k == 2) o.lever_arm_m = {1};
    if (k == 3) o.bias_curve = {1, 2, 3};
    if (k == 4) o.jump = {1, 2};
    if (k == 5) o.outage_s = {1};
    EXPECT_THROW(vir::simulation::simulateRanges(*motion, o), std::invalid_argument) << k;
  }
}

TEST(SimulatedRanges, TheScenesBoxesStandInTheWay) {
  const auto motion = vir_test::briskFlight();
  vir::simulation::RangeSimulationOptions o = perfect();
  const rendering::Box room{Vec3(-20, -20, -5), Vec3(20, 20, 5)};
  // A thin board before the anchor, a thick block elsewhere.
  const rendering::Scene scene(
      room, {{Vec3(3, 0, -5), Vec3(3.2, 2, 5)}, {Vec3(3, -8, -5), Vec3(6, 0, 5)}});
  const auto ranges = vir::simulation::simulateRanges(*motion, o, &scene);
  const auto all = vir::simulation::simulateRanges(*motion, o);
  long blocked = 0;
  for (const vir::simulation::SimulatedRange& r : ranges) {
    const double solid = scene.solidBetween(motion->poseAt(r.t).p, Vec3(5, 2, 1));
    EXPECT_EQ(r.line_of_sight, solid == 0);
    EXPECT_LE(solid, o.max_solid_m);
    if (r.line_of_sight) {
      EXPECT_NEAR(r.range_m, r.true_m, 1e-12);
    } else {
      ++blocked;
      EXPECT_GE(r.range_m - r.true_m, o.nlos_min_m);
      EXPECT_LE(r.range_m - r.true_m, o.nlos_max_m);
    }
  }
  EXPECT_GT(blocked, 50);
  EXPECT_LT(ranges.size(), all.size() - 50);
}

}  // namespace
