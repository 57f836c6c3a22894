/// Robots that share a radio channel take turns, and tell each other what they believe.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "made_motions.h"
#include "vir/simulation/simulate_team_ranges.h"

namespace {

using namespace vir;

std::vector<vir::simulation::TeamRobot> twoRobots() {
  vir::simulation::FlightOptions o;
  o.length_m = 60;
  std::vector<vir::simulation::TeamRobot> out;
  out.push_back(
      {0, std::make_shared<vir::simulation::Motion>(vir::simulation::flight("eight", o))});
  o.start_m = {1, 4, 0.5};
  o.start_heading_deg = 140;
  out.push_back(
      {1, std::make_shared<vir::simulation::Motion>(vir::simulation::flight("letter_s", o))});
  return out;
}

vir::simulation::RangeSimulationOptions exact() {
  vir::simulation::RangeSimulationOptions o;
  o.anchor_m = {5, 2, 1, -4, 1, 2};
  o.anchor_id = {7, 9};
  o.lever_arm_m = {0.05, 0, 0.1};
  o.sigma_m = 0;
  o.rate_hz = 10;
  return o;
}

vir::simulation::OdometrySimulationOptions exactOdometry() {
  vir::simulation::OdometrySimulationOptions o;
  o.scale_error = o.scale_wander = o.yaw_walk = o.position_walk = 0;
  o.position_noise_m = o.attitude_noise_rad = 0;
  return o;
}

Vec3 antenna(const vir::simulation::TeamRobot& r, TimeNs t) {
  return r.motion->poseAt(t) * Vec3(0.05, 0, 0.1);
}

TEST(TeamRanges, MeasureFromAntennaToAntenna) {
  const auto robots = twoRobots();
  const auto got =
      vir::simulation::simulateTeamRanges(robots, exact(), {}, exactOdometry(), nullptr);
  ASSERT_EQ(got.size(), 2u);
  for (std::size_t k = 0; k < 2; ++k) {
    ASSERT_NEAR(static_cast<double>(got[k].anchors.size()), 20 * robots[k].motion->duration(), 4);
    for (const vir::simulation::SimulatedRange& r : got[k].anchors) {
      const Vec3 anchor = r.anchor == 7 ? Vec3(5, 2, 1) : Vec3(-4, 1, 2);
      EXPECT_NEAR(r.range_m, (antenna(robots[k], r.t) - anchor).norm(), 1e-12);
    }
    const double common = std::min(robots[0].motion->duration(), robots[1].motion->duration());
    ASSERT_NEAR(static_cast<double>(got[k].peers.size()), 5 * common, 3);
    for (const vir::simulation::PeerRange& p : got[k].peers) {
      EXPECT_EQ(p.range.anchor, robots[1 - k].id);
      EXPECT_NEAR(p.range.range_m,
                  (antenna(robots[0], p.range.t) - antenna(robots[1], p.range.t)).norm(), 1e-12);
    }
  }
}

TEST(TeamRanges, NoTwoAreAtTheSameTime) {
  const auto got =
      vir::simulation::simulateTeamRanges(twoRobots(), exact(), {}, exactOdometry(), nullptr);
  std::vector<TimeNs> times;
  for (const vir::simulation::SimulatedRange& r : got[0].anchors) times.push_back(r.t);
  for (const vir::simulation::SimulatedRange& r : got[1].anchors) times.push_back(r.t);
  for (const vir::simulation::PeerRange& p : got[0].peers) times.push_back(p.range.t);
  std::sort(times.begin(), times.end());
  // Slots of a fifth of 0.1 s, used to within 0.4 of their length to either side.
  TimeNs least = fromSeconds(1);
  for (std::size_t k = 1; k < times.size(); ++k) least = std::min(least, times[k] - times[k - 1]);
  EXPECT_GT(toSeconds(least), 0.2 * 0.02 - 1e-6);
}

TEST(TeamRanges, WithoutDriftTheToldPositionsAreTheTruth) {
  const auto robots = twoRobots();
  vir::simulation::TeamRangeOptions team;
  team.anchor_sigma_m = 0;
  const auto got =
      vir::simulation::simulateTeamRanges(robots, exact(), team, exactOdometry(), nullptr);
  for (std::size_t k = 0; k < 2; ++k) {
    const vir::simulation::TeamRobot& other = robots[1 - k];
    const Pose& T_W_O = got[1 - k].T_W_O;
    for (const vir::simulation::PeerRange& p : got[k].peers) {
      ASSERT_FALSE(p.told.empty());
      EXPECT_EQ(p.told[0].anchor, -1);
      // Between the poses of the odometry it is interpolated.
      EXPECT_LT((T_W_O * p.told[0].p_O - antenna(other, p.range.t)).norm(), 2e-3);
      const double s = toSeconds(p.range.t - other.motion->begin());
      EXPECT_EQ(p.told.size(), s < team.anchor_known_s ? 1u : 3u);
      if (p.told.size() < 3) continue;
      EXPECT_EQ(p.told[1].anchor, 7);
      EXPECT_LT((T_W_O * p.told[1].p_O - Vec3(5, 2, 1)).norm(), 1e-9);
      EXPECT_LT((T_W_O * p.told[2].p_O - Vec3(-4, 1, 2)).norm(), 1e-9);
    }
  }
}

TEST(TeamRanges, DriftIsWithinWhatIsTold) {
  const auto robots = twoRobots();
  vir::simulation::OdometrySimulationOptions odometry;
  double nees = 0, n = 0;
  for (int seed = 1; seed <= 30; ++seed) {
    odometry.seed = 10 * seed;
    const auto got = vir::simulation::simulateTeamRanges(robots, exact(), {}, odometry, nullptr);
    const vir::simulation::PeerRange& last = got[0].peers.back();
    const Vec3 error = got[1].T_W_O * last.told[0].p_O - antenna(robots[1], last.range.t);
    const Mat3 R = got[1].T_W_O.R();
    nees += error.dot((R * last.told[0].covariance * R.transpose()).inverse() * error) / 3;
    n += 1;
  }
  // Only to first order, and the scale error is always its one sigma.
  EXPECT_GT(nees / n, 0.3);
  EXPECT_LT(nees / n, 2.5);
}

TEST(TeamRanges, AreRepeatableAndRefuseNonsense) {
  auto robots = twoRobots();
  vir::simulation::RangeSimulationOptions o = exact();
  o.sigma_m = 0.05;
  const auto a = vir::simulation::simulateTeamRanges(robots, o, {}, {}, nullptr);
  const auto b = vir::simulation::simulateTeamRanges(robots, o, {}, {}, nullptr);
  ASSERT_EQ(a[1].peers.size(), b[1].peers.size());
  for (std::size_t k = 0; k < a[1].peers.size(); ++k) {
    EXPECT_EQ(a[1].peers[k].range.range_m, b[1].peers[k].range.range_m);
    EXPECT_EQ(a[1].peers[k].told[0].p_O, b[1].peers[k].told[0].p_O);
    EXPECT_EQ(a[1].peers[k].range.range_m, a[0].peers[k].range.range_m);  // both get the same
  }
  vir::simulation::TeamRangeOptions alone;
  alone.peer_rate_hz = 0;
  EXPECT_TRUE(vir::simulation::simulateTeamRanges(robots, o, alone, {}, nullptr)[0].peers.empty());
  robots[1].id = robots[0].id;
  EXPECT_THROW(vir::simulation::simulateTeamRanges(robots, o, {}, {}, nullptr),
               std::invalid_argument);
  robots[1].motion = nullptr;
  EXPECT_THROW(vir::simulation::simulateTeamRanges(robots, o, {}, {}, nullptr),
               std::invalid_argument);
}

}  // namespace
