/// What becomes of ranges: bad ones, anchors that appear late, geometry that does not suffice.
#include "vir/estimator/range_layer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "odometry_range_driver.h"

namespace vir::estimator {
namespace {

using vir_test::drifting;
using vir_test::flightOf;
using vir_test::fly;
using vir_test::RangeRun;
using vir_test::rangesTo;
using vir_test::RangeWorld;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
const Vec3 kAnchor(4, 6, 2.5), kOther(-7, -4, 1.5);

std::vector<double> numbersOf(const RangeRun& run) {
  std::vector<double> out;
  for (const StateEstimate& e : run.estimates) {
    for (int i = 0; i < 3; ++i) out.push_back(e.state.T_W_B.p[i]);
    for (int i = 0; i < 4; ++i) out.push_back(e.state.T_W_B.q.coeffs()[i]);
    out.insert(out.end(), e.covariance.data(), e.covariance.data() + 36);
    out.push_back(e.odometry_scale);
  }
  return out;
}

TEST(RangeLayer, BadRangesAreCountedByReason) {
  window::LongWindow window{window::LongWindowOptions()};
  RangeLayer layer(RangeOptions(), &window, {});
  const auto offer = [&](TimeNs t, std::uint64_t id, double range_m, double sigma_m = 0.1,
                         const Vec3& lever = Vec3::Zero()) {
    Range r;
    r.t = t;
    r.anchor = id;
    r.range_m = range_m;
    r.sigma_m = sigma_m;
    r.p_B_U = lever;
    layer.offer(r);
  };
  offer(100, 1, 5);
  offer(200, 1, -5);
  offer(300, 1, kNan);
  offer(310, 1, std::numeric_limits<double>::infinity());
  offer(400, 1, 0);
  offer(500, 1, 1e9);
  offer(100, 1, 5);  // again
  offer(50, 1, 5);   // older
  offer(600, 1, 5, kNan);
  offer(700, 1, 5, 0.1, Vec3(0, kNan, 0));
  offer(800, static_cast<std::uint64_t>(-1), 5);  // a broken id
  offer(900, 1ull << 32, 5);                      // must not be taken for anchor 0
  offer(150, 2, 6);
  const auto records = layer.take();
  std::map<RangeDecision, long> counts;
  for (const RangeRecord& r : records) ++counts[r.decision];
  EXPECT_EQ(counts[RangeDecision::negative], 1);
  EXPECT_EQ(counts[RangeDecision::not_finite], 4);
  EXPECT_EQ(counts[RangeDecision::zero], 1);
  EXPECT_EQ(counts[RangeDecision::too_far], 1);
  EXPECT_EQ(counts[RangeDecision::repeated], 1);
  EXPECT_EQ(counts[RangeDecision::out_of_order], 1);
  EXPECT_EQ(counts[RangeDecision::bad_id], 2);
  EXPECT_EQ(records.size(), 11u) << "every one is recorded";
  // The two good ones wait, in order of time.
  EXPECT_EQ(layer.dueUntil(99).size(), 0u);
  const std::vector<Range> due = layer.dueUntil(1000);
  ASSERT_EQ(due.size(), 2u);
  EXPECT_EQ(due[0].t, 100);
  EXPECT_EQ(due[1].t, 150);
  EXPECT_EQ(layer.dueUntil(1000).size(), 0u);
  layer.discard(due, RangeDecision::too_late);
  const auto decisions = layer.take();
  ASSERT_EQ(decisions.size(), 2u);
  EXPECT_EQ(decisions[1].decision, RangeDecision::too_late);
  EXPECT_EQ(decisions[1].anchor, 2u);
}

TEST(RangeLayer, BadRangesChangeNothing) {
  const RangeWorld world(simulation::flight("eight", flightOf(40)), drifting(),
                         rangesTo({kAnchor}));
  std::vector<Range> dirty;
  Range early = world.ranges.front();
  early.t = world.motion.begin() - 50000000;
  early.anchor = 7;
  dirty.push_back(early);
  long n = 0;
  for (std::size_t k = 0; k < world.ranges.size(); ++k) {
    Range r = world.ranges[k];
    dirty.push_back(r);
    if (k % 3) continue;
    ++n;
    dirty.push_back(r);  // repeated
    const double values[] = {-r.range_m, kNan, 0, 1e7};
    r.t += 1;
    r.range_m = values[n % 4];
    dirty.push_back(r);
    r = world.ranges[k];
    r.t -= 1;  // out of order
    dirty.push_back(r);
    if (k % 60) continue;
    r.t += 2;
    r.anchor = 4711;  // heard of a few times only
    r.range_m = 3.3;
    dirty.push_back(r);
  }
  const RangeRun clean = fly(world), with = fly(world, {}, dirty);
  EXPECT_EQ(numbersOf(clean), numbersOf(with));
  EXPECT_EQ(with.count(RangeDecision::repeated), n);
  EXPECT_EQ(with.count(RangeDecision::out_of_order), n);
  EXPECT_EQ(with.count(RangeDecision::negative) + with.count(RangeDecision::not_finite) +
                with.count(RangeDecision::zero) + with.count(RangeDecision::too_far),
            n);
  EXPECT_EQ(with.count(RangeDecision::before_the_start),
            1 + clean.count(RangeDecision::before_the_start));
  EXPECT_EQ(with.decisions.size(), dirty.size()) << "every range is accounted for";
  ASSERT_TRUE(with.anchor(4711));
  EXPECT_FALSE(with.anchor(4711)->has_position);
  EXPECT_EQ(with.anchor(4711)->state, AnchorState::collecting);
  ASSERT_TRUE(with.anchor(0) && clean.anchor(0));
  EXPECT_TRUE(clean.anchor(0)->has_position);
  EXPECT_EQ(with.anchor(0)->p_W, clean.anchor(0)->p_W);
}

TEST(RangeLayer, AnAnchorFoundLate) {
  const RangeWorld world(simulation::flight("eight", flightOf(120)), drifting(),
                         rangesTo({kAnchor}));
  std::vector<Range> late;
  for (const Range& r : world.ranges) {
    if (r.t > world.time(50)) late.push_back(r);
  }
  const RangeRun run = fly(world, {}, late);
  ASSERT_TRUE(run.anchor(0) && run.anchor(0)->has_position);
  const Vec3 error = run.anchor(0)->p_W - world.anchor(0);
  RecordProperty("anchor_error_m", std::to_string(error.norm()));
  // It stands where the drift of the way there puts it: its covariance must say so.
  EXPECT_LT(error.norm(), 1.5);
  EXPECT_LT(error.dot(run.anchor(0)->covariance.ldlt().solve(error)), 16.3);  // 99.9 %
}

TEST(RangeLayer, TwoAnchorsOneAfterAnother) {
  const RangeWorld world(simulation::flight("eight", flightOf(120)), drifting(),
                         rangesTo({kAnchor, kOther}));
  std::vector<Range> some;
  for (const Range& r : world.ranges) {
    if (r.anchor == 0 || r.t > world.time(40)) some.push_back(r);
  }
  TimeNs found[2] = {0, 0};
  const RangeRun run =
      fly(world, {}, some, [&](const OdometryRangeEstimator& e, const StateEstimate& now) {
        for (const Anchor& a : e.anchors()) {
          if (a.has_position && !found[a.id]) found[a.id] = now.state.t;
        }
      });
  EXPECT_GT(found[0], 0);
  EXPECT_LT(found[0], world.time(30));
  EXPECT_GT(found[1], world.time(40));
  EXPECT_LT(found[1], world.time(70));
  ASSERT_EQ(run.anchors.size(), 2u);
  for (std::size_t a = 0; a < 2; ++a) {
    EXPECT_EQ(run.anchors[a].state, AnchorState::estimated) << a;
    EXPECT_LT((run.anchors[a].p_W - world.anchor(a)).norm(), 1.0) << a;
  }
}

TEST(RangeLayer, PlanarFlightKeepsBothImagesUntilAClimb) {
  for (double z : {2.0, -2.0}) {
    // Two rounds at one height, then round and up.
    std::vector<Vec3> points;
    for (int k = 0; k <= 150; ++k) {
      const double a = 2 * M_PI * k / 50;
      points.emplace_back(6 * std::sin(a), 3 * std::sin(2 * a), 0.05 * std::max(0, k - 100));
    }
    simulation::FlightOptions level;
    level.sway_m = level.sway_deg = level.height_m = 0;
    auto gentle = drifting();
    gentle.scale_error = 0.02;
    gentle.position_walk = 0.003;
    gentle.yaw_walk = 0.003;
    OdometryRangeConfig config;
    config.odometry.noise.sigma_per_sqrt_m = 0.01;
    config.odometry.noise.yaw_per_sqrt_m = 0.005;
    auto ranges = rangesTo({Vec3(4, 6, z)});
    ranges.lever_arm_m = {0, 0, 0};
    const RangeWorld world(simulation::flyAlong(points, level), gentle, ranges);
    bool seen = false;
    TimeNs found = 0;
    const RangeRun run =
        fly(world, config, [&](const OdometryRangeEstimator& e, const StateEstimate& now) {
          const Pose truth = world.truth(now.state.t);
          if (truth.p.z() > 0.02 || e.anchors().empty()) return;
          const Anchor a = e.anchors().front();
          if (!a.has_position) return;
          if (!found) found = now.state.t;
          // The images are compared some keyframes after the first position only.
          if (now.state.t < found + fromSeconds(5)) return;
          ASSERT_EQ(a.state, AnchorState::mirror_open)
              << toSeconds(now.state.t - world.motion.begin()) << " s";
          EXPECT_NE(a.advice.find("height"), std::string::npos) << a.advice;
          EXPECT_NE(a.advice.find(" m up would tell most"), std::string::npos) << a.advice;
          ASSERT_TRUE(a.waypoint_W);
          EXPECT_GT(a.waypoint_W->z(), 0.4);
          EXPECT_GT(std::sqrt(a.covariance(2, 2)), 1.0);
          EXPECT_LT(std::sqrt(a.covariance(0, 0)), 2.0);
          // It spans both positions: half the way between them is one sigma at least, so that the
          // other one lies within two. Nobody has to widen it again.
          const Vec3 apart = a.mirror_p_W - a.p_W;
          const Vec3 along = apart.normalized();
          EXPECT_GE(along.dot(a.covariance * along), 0.25 * apart.squaredNorm());
          EXPECT_LE(apart.dot(a.covariance.ldlt().solve(apart)), 4.0);
          EXPECT_LT(along.dot(a.covariance * along), 0.5 * apart.squaredNorm() + 0.5);
          seen = true;
        });
    EXPECT_TRUE(seen);
    ASSERT_EQ(run.anchors.size(), 1u);
    EXPECT_EQ(run.anchors[0].state, AnchorState::estimated) << "anchor at height " << z;
    EXPECT_LT((run.anchors[0].p_W - world.anchor(0)).norm(), 0.6) << "anchor at height " << z;
    EXPECT_LT(std::sqrt(run.anchors[0].covariance(2, 2)), 0.5);
  }
}

TEST(RangeLayer, AStraightLineAsksToMoveSideways) {
  simulation::FlightOptions straight;
  straight.sway_m = straight.sway_deg = straight.height_m = 0;
  auto gentle = drifting();
  gentle.yaw_walk = gentle.position_walk = 0.0005;
  const RangeWorld world(simulation::flyAlong({Vec3::Zero(), Vec3(20, 0, 0)}, straight), gentle,
                         rangesTo({Vec3(10, 4, 1)}));
  // A device of unknown scale takes an anchor that is known to a few metres; a ring of radius 4 m
  // is none the less nothing to use when a metre is asked for.
  OdometryRangeConfig config;
  config.ranges = RangeOptions();
  const RangeRun run = fly(world, config);
  ASSERT_EQ(run.anchors.size(), 1u);
  EXPECT_FALSE(run.anchors[0].has_position);
  EXPECT_EQ(run.anchors[0].state, AnchorState::collecting);
  EXPECT_NE(run.anchors[0].advice.find("move sideways"), std::string::npos)
      << run.anchors[0].advice;
  EXPECT_GT(run.count(RangeDecision::collected), 50);
}

/// So is a ring for a device of unknown scale, which takes an anchor known to a few metres.
TEST(RangeLayer, AStraightLineIsARingForTheOdometryModeToo) {
  simulation::FlightOptions straight;
  straight.sway_m = straight.sway_deg = straight.height_m = 0;
  auto gentle = drifting();
  gentle.yaw_walk = gentle.position_walk = 0.0005;
  const RangeWorld world(simulation::flyAlong({Vec3::Zero(), Vec3(20, 0, 0)}, straight), gentle,
                         rangesTo({Vec3(10, 4, 1)}));
  const RangeRun run = fly(world);
  ASSERT_EQ(run.anchors.size(), 1u);
  EXPECT_FALSE(run.anchors[0].has_position);
  EXPECT_NE(run.anchors[0].advice.find("move sideways"), std::string::npos)
      << run.anchors[0].advice;
  // Along y or z, where nobody has been.
  ASSERT_TRUE(run.anchors[0].waypoint_W);
  EXPECT_GT(run.anchors[0].waypoint_W->tail<2>().norm(), 0.3) << run.anchors[0].advice;
}

TEST(RangeLayer, AnAnchorPutDownBeforeTheFirstPoseIsCounted) {
  OdometryRangeEstimator e{OdometryRangeConfig()};
  e.anchorDeployed(3, Vec3(0.1, 0, 0), 0.1);
  e.addOdometry(1000000000, Pose());
  e.anchorDeployed(4, Vec3(0.1, 0, 0), 0.1);
  e.anchorDeployed(5, Vec3(kNan, 0, 0), 0.1);
  e.anchorDeployed(static_cast<std::uint64_t>(-1), Vec3(0.1, 0, 0), 0.1);
  e.addOdometry(2000000000, Pose(Quat::Identity(), Vec3(1, 0, 0)));
  std::map<std::string, long> counts;
  for (const auto& [name, n] : e.counters()) counts[name] = n;
  EXPECT_EQ(counts["anchors_put_down_without_a_pose"], 1);
  EXPECT_EQ(counts["anchors_put_down_unusable"], 2);
  ASSERT_EQ(e.warnings().size(), 3u);
  EXPECT_NE(e.warnings()[0].find("anchor 3 was put down when there was no pose"), std::string::npos)
      << e.warnings()[0];
  ASSERT_EQ(e.anchors().size(), 1u);
  EXPECT_EQ(e.anchors()[0].id, 4u);
}

TEST(RangeLayer, APriorMayBeAsNarrowAsIsAllowed) {
  const RangeWorld world(simulation::flight("eight", flightOf(40)), drifting(),
                         rangesTo({kAnchor}));
  OdometryRangeConfig config;
  const Vec3 at = world.anchor(0);
  config.ranges.anchor_prior = {0, at.x(), at.y(), at.z(), 1e-4};
  const RangeRun run = fly(world, config);
  ASSERT_EQ(run.estimates.size(), world.odometry.size());
  for (const StateEstimate& e : run.estimates) {
    ASSERT_TRUE(e.state.T_W_B.p.allFinite() && e.covariance.allFinite());
  }
  ASSERT_TRUE(run.anchor(0) && run.anchor(0)->has_position);
  EXPECT_LT((run.anchor(0)->p_W - at).norm(), 1e-3);
  EXPECT_LT(ate(world, run), 1.0);
}

TEST(RangeLayer, ADeployedAnchorStartsFromItsPrior) {
  const RangeWorld world(simulation::flight("eight", flightOf(60)), drifting(),
                         rangesTo({kAnchor}));
  OdometryRangeConfig config;
  const Vec3 at = world.anchor(0) + Vec3(0.1, -0.1, 0.1);
  config.ranges.anchor_prior = {0, at.x(), at.y(), at.z(), 0.3};
  TimeNs with = 0, without = 0;
  const auto note = [](TimeNs* when) {
    return [when](const OdometryRangeEstimator& e, const StateEstimate& now) {
      if (!*when && !e.anchors().empty() && e.anchors()[0].has_position) *when = now.state.t;
    };
  };
  const RangeRun known = fly(world, config, note(&with));
  fly(world, {}, note(&without));
  ASSERT_GT(with, 0);
  EXPECT_LT(with, without);
  EXPECT_LT((known.anchors[0].p_W - world.anchor(0)).norm(), 0.3);
  EXPECT_EQ(known.anchors[0].state, AnchorState::estimated);
}

}  // namespace
}  // namespace vir::estimator
