/// Settings at and beyond the ends of what they may be: refused by the reader of settings, by the
/// simulator, or what comes out is made of numbers.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "made_motions.h"
#include "vir/camera/camera_model.h"
#include "vir/core/options.h"
#include "vir/simulation/simulate_imu.h"
#include "vir/simulation/simulate_odometry.h"
#include "vir/simulation/simulate_ranges.h"
#include "vir/simulation/simulate_team_ranges.h"
#include "vir/simulation/track_simulator.h"
#include "vir_test_extremes.h"

namespace vir::simulation {
namespace {

/// Puts a number into the `place`-th option, if a reader of settings would let it in.
class PutOne : public OptionVisitor {
 public:
  PutOne(int place, double number) : place_(place), number_(number) {}
  void section(const std::string&, const std::string&) override {}
  void value(const char*, bool&, const char*) override {}
  void value(const char* key, int& v, Bounds<int> bounds, const char*) override {
    if (!here(key) || !(number_ >= bounds.min && number_ <= bounds.max)) return;
    v = static_cast<int>(number_);
    put = true;
  }
  void value(const char* key, double& v, Bounds<double> bounds, const char*) override {
    if (!here(key) || !(number_ >= bounds.min && number_ <= bounds.max)) return;
    v = number_;
    put = true;
  }
  void value(const char*, std::string&, const char*) override {}
  void value(const char* key, std::vector<double>& v, std::size_t size, const char*) override {
    if (!here(key) || !std::isfinite(number_)) return;
    v.assign(size > 0 ? size : 6, number_);
    put = true;
  }
  void choice(const char*, std::string&, const std::vector<std::string>&, const char*) override {}

  bool put = false;
  std::string key;  ///< of that place
  bool reached() const { return seen_ > place_; }

 private:
  bool here(const char* k) {
    const bool is = seen_++ == place_;
    if (is) key = k;
    return is;
  }
  int place_, seen_ = 0;
  double number_;
};

std::vector<double> numbers() {
  std::vector<double> all(test::extremes().begin(), test::extremes().end());
  for (const double x : {0.5, 1e3, 1e6, 2147483647.0, -2147483648.0}) all.push_back(x);
  return all;
}

/// `simulate(options)` for each number in each place of `Options`.
template <typename Options, typename Simulate>
void tryAll(const Options& usual, const Simulate& simulate) {
  int places = 0, tried = 0;
  for (bool more = true; more; ++places) {
    for (const double x : numbers()) {
      Options o = usual;
      PutOne put(places, x);
      describe(put, o);
      more = put.reached();
      if (!put.put) continue;
      ++tried;
      SCOPED_TRACE(put.key + " = " + std::to_string(x));
      try {
        simulate(o);
      } catch (const std::invalid_argument&) {
      }
    }
  }
  EXPECT_GT(tried, 3 * (places - 1)) << "most places take some of the numbers";
}

std::shared_ptr<const Motion> shortFlight() {
  FlightOptions o;
  o.length_m = 3;
  o.rest_s = 0.2;
  return std::make_shared<Motion>(flight("eight", o));
}

TEST(ExtremeNumbers, ReadingsOfTheImu) {
  const auto motion = shortFlight();
  tryAll(ImuSimulationOptions(), [&](const ImuSimulationOptions& o) {
    const SimulatedImu imu = simulateImu(*motion, o);
    for (const ImuSample& s : imu.samples) {
      ASSERT_TRUE(s.gyro.allFinite() && s.acc.allFinite());
      ASSERT_TRUE(s.t >= motion->begin() && s.t <= motion->end());
    }
  });
}

TEST(ExtremeNumbers, PosesOfAnOdometry) {
  const auto motion = shortFlight();
  tryAll(OdometrySimulationOptions(), [&](const OdometrySimulationOptions& o) {
    for (const StampedPose& s : simulateOdometry(*motion, o)) {
      ASSERT_TRUE(s.T_W_B.p.allFinite() && s.T_W_B.q.coeffs().allFinite());
    }
  });
}

TEST(ExtremeNumbers, RangesToAnchorsAndRobots) {
  const auto motion = shortFlight();
  RangeSimulationOptions usual;
  usual.anchor_m = {3, 2, 1, -4, 0, 2};
  const auto check = [](const std::vector<SimulatedRange>& ranges) {
    for (const SimulatedRange& r : ranges) {
      ASSERT_TRUE(std::isfinite(r.range_m) && std::isfinite(r.true_m));
    }
  };
  tryAll(usual, [&](const RangeSimulationOptions& o) { check(simulateRanges(*motion, o)); });
  const std::vector<TeamRobot> robots{{1, motion}, {2, motion}};
  const auto team = [&](const RangeSimulationOptions& o, const TeamRangeOptions& t) {
    for (const RobotRanges& r : simulateTeamRanges(robots, o, t, {}, nullptr)) {
      check(r.anchors);
      for (const PeerRange& p : r.peers) {
        check({p.range});
        for (const ToldPosition& told : p.told) {
          ASSERT_TRUE(told.p_O.allFinite() && told.covariance.allFinite());
        }
      }
    }
  };
  tryAll(usual, [&](const RangeSimulationOptions& o) { team(o, {}); });
  tryAll(TeamRangeOptions(), [&](const TeamRangeOptions& t) { team(usual, t); });
}

TEST(ExtremeNumbers, Tracks) {
  const auto motion = vir_test::standing(1);
  CameraCalibration c;
  c.width = 320;
  c.height = 240;
  c.fx = c.fy = 250;
  c.cx = 160;
  c.cy = 120;
  TrackSimulationOptions usual;
  usual.rate_hz = 4;
  usual.wall_density = 2;
  tryAll(usual, [&](const TrackSimulationOptions& o) {
    // What is allowed and takes long: millions of points, thousands of images.
    if (o.wall_density > 100 || o.room_margin_m > 100 || o.rate_hz > 100) return;
    TrackSimulator tracks(o, motion, camera::makeCamera(c), Pose());
    for (const TimeNs t : tracks.times()) {
      for (const vision::FeatureObservation& f : tracks.at(t).features) {
        ASSERT_TRUE(f.px.allFinite() && f.bearing.allFinite() && f.bearing_rate.allFinite());
      }
    }
  });
}

TEST(ExtremeNumbers, Flights) {
  FlightOptions usual;
  usual.length_m = 20;
  usual.rest_s = 0.2;
  for (const std::string name : {"eight", "stop_and_go", "standing"}) {
    SCOPED_TRACE(name);
    tryAll(usual, [&](const FlightOptions& o) {
      // Flights of days are allowed and take long.
      if (o.length_m / o.speed_mps + o.rest_s + o.stop_s > 1e3) return;
      const Motion motion = flight(name, o);
      const MotionState s = motion.at(motion.begin() + (motion.end() - motion.begin()) / 2);
      ASSERT_TRUE(s.T_W_B.p.allFinite() && s.T_W_B.q.coeffs().allFinite() && s.v_W.allFinite() &&
                  s.a_W.allFinite() && s.rate_B.allFinite());
    });
  }
}

/// Poses of a recording that is flown again.
TEST(ExtremeNumbers, FlyingAgain) {
  Trajectory recorded;
  for (int k = 0; k < 60; ++k) {
    recorded.push_back({50'000'000LL * k, {Quat::Identity(), Vec3(0.1 * k, 0, 1)}});
  }
  test::forExtremeVectors(recorded[30].T_W_B.p, [&](const Vec3& p) {
    SCOPED_TRACE(testing::Message() << p.transpose());
    Trajectory spoilt = recorded;
    spoilt[30].T_W_B.p = p;
    try {
      const Motion motion = flyAgain(spoilt, {});
      const MotionState s = motion.at(motion.begin() + 1'500'000'000);
      EXPECT_TRUE(s.T_W_B.p.allFinite() && s.a_W.allFinite());
    } catch (const std::invalid_argument&) {
    }
  });
  for (const double x : test::extremes()) {
    for (int place = 0; place < 4; ++place) {
      SCOPED_TRACE(testing::Message() << x << " in place " << place);
      FlyAgainOptions o;
      (place == 0 ? o.from_s : place == 1 ? o.duration_s : place == 2 ? o.knot_s : o.smooth_s) = x;
      try {
        const Motion motion = flyAgain(recorded, o);
        EXPECT_TRUE(motion.at(motion.begin()).T_W_B.p.allFinite());
      } catch (const std::invalid_argument&) {
      }
    }
  }
}

}  // namespace
}  // namespace vir::simulation
