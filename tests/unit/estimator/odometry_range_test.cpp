/// Odometry and ranges over whole flights: how good, how honest, and what it does when ranges lie.
#include <gtest/gtest.h>

#include <cstring>

#include "odometry_range_driver.h"
#include "vir/core/angles.h"
#include "vir/evaluation/nees.h"
#include "vir_test_noise.h"

namespace vir::estimator {
namespace {

using vir_test::ate;
using vir_test::drifting;
using vir_test::flightOf;
using vir_test::fly;
using vir_test::RangeRun;
using vir_test::rangesTo;
using vir_test::RangeWorld;

const Vec3 kAnchor(4, 6, 2.5);

TEST(OdometryRange, RangesHalveTheDrift) {
  double sum_with = 0, sum_without = 0, mean_scale = 0;
  for (int seed : {1, 2, 3}) {
    const RangeWorld world(simulation::flight("eight", flightOf(120, seed)), drifting(seed),
                           rangesTo({kAnchor}, seed));
    const double without = ate(world, fly(world, {}, std::vector<Range>()));
    const RangeRun run = fly(world);
    const double with = ate(world, run);
    std::printf("seed %d: ATE without ranges %.3f m, with %.3f m\n", seed, without, with);
    sum_with += with;
    sum_without += without;
    EXPECT_LT(with, 0.6 * without) << seed;
    ASSERT_TRUE(run.anchor(0) && run.anchor(0)->has_position);
    EXPECT_LT((run.anchor(0)->p_W - world.anchor(0)).norm(), 0.5) << seed;
    mean_scale += run.estimates.back().odometry_scale / 3;
    EXPECT_NEAR(run.estimates.back().odometry_scale, 1.05, 0.05) << seed;
    // Next to nothing is seen of a constant error: it is known as it was before, and no worse.
    EXPECT_LE(run.anchor(0)->bias_sigma_m, 1.001 * OdometryRangeConfig().ranges.bias_sigma_m)
        << seed;
    EXPECT_GE(run.anchor(0)->bias_sigma_m, 0.6 * OdometryRangeConfig().ranges.bias_sigma_m) << seed;
  }
  EXPECT_LT(sum_with, 0.5 * sum_without);
  EXPECT_NEAR(mean_scale, 1.05, 0.03);
}

/// Lanes of 40 m, 1.5 m apart, at 1 m/s.
simulation::Motion mowing(int lanes) {
  Trajectory poses;
  const double speed = 1, rate = 10, length = 40, apart = 1.5;
  const TimeNs begin = fromSeconds(1000);
  double s = 0;
  const double lane = length + apart, whole = lanes * lane;
  for (; s < whole; s += speed / rate) {
    const int k = static_cast<int>(s / lane);
    const double along = std::min(s - k * lane, length), across = s - k * lane - along;
    const bool back = k % 2 == 1;
    const Vec3 p(back ? length - along : along, k * apart + across, 0);
    const double yaw = across > 0 ? kPi / 2 : back ? kPi : 0;
    poses.push_back({begin + fromSeconds(s / speed), Pose(Quat(rotZ(yaw)), p)});
  }
  return simulation::Motion(begin, speed / rate, poses);
}

/// Ranges from a floor tell an anchor's height by its square only (what a search makes of that:
/// AnchorInitialization.FromAFloorAFarAnchorIsFoundWithoutItsHeight).
TEST(OdometryRange, AMowerUsesItsAnchorsWhateverTheirHeights) {
  auto ranges = rangesTo({{-5, -4, 1.2}, {45, -3, 0.9}, {46, 22, 1.5}, {-6, 20, 0.7}});
  ranges.rate_hz = 1.5;
  ranges.sigma_m = 0.25;
  double with = 0, bare = 0;
  for (int seed : {1, 4, 5, 6}) {
    // The odometry's height wanders too, by 0.3 m: the floor is level none the less.
    ranges.seed = seed;
    const RangeWorld world(mowing(6), drifting(seed), ranges);
    const RangeRun run = fly(world);
    for (std::size_t i = 0; i < 4; ++i) {
      ASSERT_TRUE(run.anchor(i));
      EXPECT_GT(run.anchor(i)->ranges_used, 100)
          << "seed " << seed << ", " << i << ": " << run.anchor(i)->advice;
    }
    with += ate(world, run) / 4;
    bare += ate(world, fly(world, {}, std::vector<Range>())) / 4;
  }
  std::printf("ATE without ranges %.2f m, with %.2f m\n", bare, with);
  EXPECT_LT(with, 0.75 * bare);
}

TEST(OdometryRange, NoLineOfSightCostsLittle) {
  double clean = 0, nlos = 0;
  for (int seed = 1; seed <= 5; ++seed) {
    auto ranges = rangesTo({kAnchor}, seed);
    const simulation::Motion motion = simulation::flight("eight", flightOf(120, seed));
    const RangeWorld good(motion, drifting(seed), ranges);
    ranges.nlos_share = 0.1;
    const RangeWorld bad(motion, drifting(seed), ranges);
    const double a = ate(good, fly(good)), b = ate(bad, fly(bad));
    std::printf("seed %d: ATE clean %.3f m, 10 %% without line of sight %.3f m\n", seed, a, b);
    clean += a;
    nlos += b;
    EXPECT_LT(b, 1.3 * a + 0.02) << seed;
  }
  EXPECT_LT(nlos, 1.3 * clean);
}

TEST(OdometryRange, AMovedAnchorIsNoticedAndFoundAgain) {
  double anchor_off = 0, robot_off = 0;
  for (int seed : {1, 2, 3, 4}) {
    auto ranges = rangesTo({kAnchor}, seed);
    ranges.jump = {0, 70, -5, -5, 1.5};
    const RangeWorld world(simulation::flight("eight", flightOf(240, seed)), drifting(seed),
                           ranges);
    TimeNs lost = 0, found = 0;
    const RangeRun run =
        fly(world, {}, [&](const OdometryRangeEstimator& e, const StateEstimate& now) {
          if (e.anchors().empty()) return;
          const Anchor a = e.anchors().front();
          if (!lost && a.state == AnchorState::moved) lost = now.state.t;
          if (lost && !found && a.has_position) found = now.state.t;
        });
    EXPECT_TRUE(run.warned("moved"));
    EXPECT_EQ(run.count("anchors_found_anew"), 1);
    ASSERT_GT(lost, 0);
    EXPECT_GT(lost, world.time(70));
    EXPECT_LT(lost, world.time(90));
    ASSERT_GT(found, 0);
    EXPECT_LT(found, world.time(130));
    ASSERT_TRUE(run.anchor(0) && run.anchor(0)->has_position);
    const double off = (run.anchor(0)->p_W - world.anchor(0, 200)).norm();
    // What the wrong ranges did before they were noticed has been taken back.
    const StateEstimate& last = run.estimates.back();
    const double last_off = (last.state.T_W_B.p - world.truth(last.state.t).p).norm();
    std::printf("moved at 70 s, noticed at %.1f s, found again at %.1f s, in the end %.2f m off\n",
                toSeconds(lost - world.motion.begin()), toSeconds(found - world.motion.begin()),
                off);
    EXPECT_LT(off, 1.5) << seed << ": it was moved by 14 m";
    anchor_off += off / 4;
    robot_off += last_off / 4;
  }
  EXPECT_LT(anchor_off, 1.0);
  EXPECT_LT(robot_off, 0.7);
}

TEST(OdometryRange, AnAnchorThatOnlySeemedMovedIsTakenUpAgain) {
  auto ranges = rangesTo({kAnchor});
  // As seen from there for 25 s, then again from where it was.
  ranges.jump = {0, 70, -5, -5, 1.5, 0, 95, kAnchor.x(), kAnchor.y(), kAnchor.z()};
  const simulation::Motion motion = simulation::flight("eight", flightOf(240));
  const RangeWorld world(motion, drifting(), ranges);
  const RangeRun run = fly(world);
  EXPECT_EQ(run.count("anchors_taken_up_again"), 1);
  ASSERT_TRUE(run.anchor(0) && run.anchor(0)->has_position);
  EXPECT_LT((run.anchor(0)->p_W - world.anchor(0, 200)).norm(), 0.6);
  // As after an outage of the same length.
  ranges.jump.clear();
  ranges.outage_s = {70, 95};
  const RangeWorld plain(motion, drifting(), ranges);
  EXPECT_LT(ate(world, run), 1.3 * ate(plain, fly(plain)));
}

TEST(OdometryRange, AnOutageCausesNoJump) {
  for (int seed : {1, 2, 3}) {
    auto ranges = rangesTo({kAnchor}, seed);
    ranges.outage_s = {50, 70};
    const RangeWorld world(simulation::flight("eight", flightOf(150, seed)), drifting(seed),
                           ranges);
    const RangeRun run = fly(world);
    double worst = 0, largest = 0, error = 0;
    for (std::size_t k = 1; k < run.estimates.size(); ++k) {
      const StateEstimate &a = run.estimates[k - 1], &b = run.estimates[k];
      if (a.state.t < world.time(45) || a.state.t > world.time(80)) continue;
      const Pose step = world.odometry[k - 1].T_W_B.inverse() * world.odometry[k].T_W_B;
      const Vec3 jump = b.state.T_W_B.p - (a.state.T_W_B * step).p;
      const Mat3 P = a.covariance.topLeftCorner<3, 3>();
      largest = std::max(largest, jump.norm());
      worst = std::max(worst, std::sqrt(jump.dot(P.ldlt().solve(jump))));
    }
    for (const StateEstimate& e : run.estimates) {
      if (e.state.t > world.time(75)) {
        error = std::max(error, (e.state.T_W_B.p - world.truth(e.state.t).p).norm());
      }
    }
    std::printf("seed %d: largest correction %.3f m, %.2f sigma; after it %.2f m off at most\n",
                seed, largest, worst, error);
    EXPECT_LT(worst, 3) << seed;
    EXPECT_LT(error, 0.8) << seed;
  }
}

/// NEES of what was estimated, summed.
struct Honesty {
  double position = 0, anchor = 0;
  long positions = 0, anchors = 0;
};

/// An odometry that errs as the settings say: random walks of position and yaw, a scale that is off
/// by a random amount and wanders.
struct HonestSettings {
  explicit HonestSettings(int seed) {
    constexpr double kSpeed = 1.5, kScale = 0.05;
    vir::test::Noise noise(static_cast<std::uint64_t>(1000 + seed));
    simulated.seed = seed;
    simulated.scale_error = kScale * noise.normal();
    simulated.scale_wander = 0.01;
    simulated.scale_wander_s = 10;
    simulated.position_walk = 0.02;
    simulated.yaw_walk = 0.005;
    auto& assumed = config.odometry.noise;
    assumed.sigma_per_sqrt_m = simulated.position_walk / std::sqrt(kSpeed);
    assumed.sigma_per_rad_m = 0;
    assumed.vertical_share = 1;
    assumed.yaw_per_sqrt_m = assumed.yaw_per_sqrt_rad = 0;
    assumed.yaw_per_sqrt_s = simulated.yaw_walk;
    config.long_window.scale_sigma = kScale;
    config.long_window.scale_walk_per_sqrt_m =
        simulated.scale_wander * std::sqrt(2 / simulated.scale_wander_s / kSpeed);
    config.long_window.size = 150;
  }
  simulation::OdometrySimulationOptions simulated;
  OdometryRangeConfig config;
};

/// Adds a flight's every twentieth position from its tenth second on, and its anchor.
void addFlight(int seed, Honesty* all) {
  const HonestSettings settings(seed);
  const RangeWorld world(simulation::flight("eight", flightOf(75, seed)), settings.simulated,
                         rangesTo({kAnchor}, seed));
  const RangeRun run = fly(world, settings.config);
  double value = 0, sum = 0;
  long n = 0;
  for (std::size_t k = 0; k < run.estimates.size(); k += 20) {
    const StateEstimate& e = run.estimates[k];
    if (e.state.t < world.time(10)) continue;
    if (!evaluation::nees(e.state.T_W_B.p - world.truth(e.state.t).p,
                          e.covariance.topLeftCorner<3, 3>(), &value)) {
      ADD_FAILURE() << "no covariance at " << e.state.t << ", seed " << seed;
      continue;
    }
    sum += value;
    ++n;
  }
  all->position += sum;
  all->positions += n;
  ASSERT_TRUE(run.anchor(0)) << seed;
  const Anchor& a = *run.anchor(0);
  const bool known =
      a.has_position && evaluation::nees(a.p_W - world.anchor(0), a.covariance, &value);
  EXPECT_TRUE(known) << seed;
  if (known) {
    all->anchor += value;
    ++all->anchors;
  }
  std::printf("seed %2d: position NEES %.2f, anchor NEES %.2f (%.3f m off), scale %.3f of %.3f\n",
              seed, sum / static_cast<double>(n), value, (a.p_W - world.anchor(0)).norm(),
              run.estimates.back().odometry_scale, 1 + settings.simulated.scale_error);
}

TEST(OdometryRange, IsAsSureAsItMayBe) {
  constexpr int kRuns = 20;
  Honesty all;
  for (int seed = 1; seed <= kRuns; ++seed) ASSERT_NO_FATAL_FAILURE(addFlight(seed, &all));
  const double position = all.position / static_cast<double>(all.positions);
  const double anchor = all.anchor / static_cast<double>(all.anchors);
  std::printf("mean NEES of the position %.2f, of the anchor %.2f\n", position, anchor);
  EXPECT_GT(position, 0.5 * 3);
  EXPECT_LT(position, 2.0 * 3);
  EXPECT_GT(anchor, 0.5 * 3);
  EXPECT_LT(anchor, 2.0 * 3);
}

TEST(OdometryRange, ByteForByteTheSameTwice) {
  std::vector<double> numbers[2];
  for (std::vector<double>& out : numbers) {
    const RangeWorld world(simulation::flight("eight", flightOf(40)), drifting(),
                           rangesTo({kAnchor}));
    const RangeRun run = fly(world);
    for (const StateEstimate& e : run.estimates) {
      for (int i = 0; i < 3; ++i) out.push_back(e.state.T_W_B.p[i]);
      out.insert(out.end(), e.covariance.data(), e.covariance.data() + 36);
    }
    for (const Anchor& a : run.anchors) {
      for (int i = 0; i < 3; ++i) out.push_back(a.p_W[i]);
    }
  }
  ASSERT_EQ(numbers[0].size(), numbers[1].size());
  EXPECT_EQ(std::memcmp(numbers[0].data(), numbers[1].data(), numbers[0].size() * sizeof(double)),
            0);
}

TEST(OdometryRange, BadOdometryIsCountedAndChangesNothing) {
  const RangeWorld world(simulation::flight("eight", flightOf(30)), drifting(),
                         rangesTo({kAnchor}));
  const RangeRun clean = fly(world);
  OdometryRangeEstimator e{OdometryRangeConfig()};
  std::size_t next = 0;
  std::vector<StateEstimate> out;
  for (std::size_t k = 0; k < world.odometry.size(); ++k) {
    const StampedPose& p = world.odometry[k];
    for (; next < world.ranges.size() && world.ranges[next].t <= p.t; ++next) {
      e.addRange(world.ranges[next]);
    }
    e.addOdometry(p.t, p.T_W_B);
    e.addOdometry(p.t, p.T_W_B);                                      // repeated
    e.addOdometry(p.t - 1, Pose(Quat::Identity(), Vec3(9, 9, 9)));    // out of order
    e.addOdometry(p.t + 1, Pose(Quat::Identity(), Vec3(NAN, 0, 0)));  // not finite
    e.addOdometry(p.t + 2, Pose(Quat(0, 0, 0, 0), Vec3(1, 0, 0)));    // no attitude
    for (const StateEstimate& now : e.take()) out.push_back(now);
  }
  ASSERT_EQ(out.size(), clean.estimates.size());
  for (std::size_t k = 0; k < out.size(); ++k) {
    ASSERT_EQ(out[k].state.T_W_B.p, clean.estimates[k].state.T_W_B.p) << k;
    ASSERT_EQ(out[k].covariance, clean.estimates[k].covariance) << k;
  }
  std::map<std::string, long> counts;
  for (const auto& [name, n] : e.counters()) counts[name] = n;
  const long n = static_cast<long>(world.odometry.size());
  EXPECT_EQ(counts["odometry_poses"], 5 * n);
  EXPECT_EQ(counts["odometry_not_finite"], 2 * n);
  EXPECT_EQ(counts["odometry_out_of_order"], 2 * n);
}

TEST(OdometryRange, AJumpOfTheOdometryIsSurvived) {
  RangeWorld world(simulation::flight("eight", flightOf(120)), drifting(), rangesTo({kAnchor}));
  const std::size_t at = world.odometry.size() / 2;
  for (std::size_t k = at; k < world.odometry.size(); ++k) {
    world.odometry[k].T_W_B.p += Vec3(30, -20, 5);
  }
  const RangeRun run = fly(world);
  EXPECT_EQ(run.count("odometry_jumps"), 1);
  EXPECT_TRUE(run.warned("jumped"));
  EXPECT_EQ(run.estimates.back().segment, 1);
  for (const StateEstimate& e : run.estimates) {
    ASSERT_TRUE(e.state.T_W_B.p.allFinite() && e.covariance.allFinite());
  }
  // It cannot know how far the jump was, and must say so.
  const Mat3 before = run.estimates[at - 1].covariance.topLeftCorner<3, 3>();
  const Mat3 after = run.estimates[at].covariance.topLeftCorner<3, 3>();
  EXPECT_GT(after.trace(), 4 * before.trace());
}

/// Shorter than max_step_m, but faster than anything goes.
TEST(OdometryRange, AStepThatNothingIsFastEnoughForIsAJump) {
  RangeWorld world(simulation::flight("eight", flightOf(40)), drifting(), rangesTo({kAnchor}));
  for (std::size_t k = world.odometry.size() / 2; k < world.odometry.size(); ++k) {
    world.odometry[k].T_W_B.p += Vec3(1.5, 0, 0);
  }
  OdometryRangeConfig config;
  config.odometry.max_speed_mps = 5;
  EXPECT_EQ(fly(world, config).count("odometry_jumps"), 1);
  config.odometry.max_speed_mps = 1000;
  EXPECT_EQ(fly(world, config).count("odometry_jumps"), 0);
}

}  // namespace
}  // namespace vir::estimator
