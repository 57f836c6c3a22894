/// Poses, rates and accelerations of a simulated motion belong together; flights are as said.
#include "vir/simulation/motion.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "made_motions.h"

namespace {

using namespace vir;

const Vec3 kGravity(0, 0, -9.81);

/// What a navigator knows who has only rates and accelerations: fourth order in time.
vir::simulation::MotionState integrate(const vir::simulation::Motion& motion, TimeNs begin,
                                       TimeNs end, TimeNs step) {
  vir::simulation::MotionState s = motion.at(begin);
  for (TimeNs t = begin; t + step <= end; t += step) {
    const double h = toSeconds(step);
    const vir::simulation::MotionState a = motion.at(t), b = motion.at(t + step / 2),
                                       c = motion.at(t + step);
    // Magnus expansion of the attitude to fourth order, with the rates at the ends and the middle.
    const auto turn = [](const Vec3& w0, const Vec3& w1, const Vec3& w2, double dt) {
      const Vec3 mean = (w0 + 4 * w1 + w2) / 6, slope = (w2 - w0) / dt;
      return Vec3(mean * dt + dt * dt * dt / 12 * mean.cross(slope));
    };
    const Vec3 quarter_rate = (3 * a.rate_B + 6 * b.rate_B - c.rate_B) / 8;
    const Quat q0 = s.T_W_B.q;
    const Quat q1 = q0 * expQuat(turn(a.rate_B, quarter_rate, b.rate_B, h / 2));
    const Quat q2 = (q0 * expQuat(turn(a.rate_B, b.rate_B, c.rate_B, h))).normalized();
    const auto force = [](const vir::simulation::MotionState& m) {
      return Vec3(m.T_W_B.q.conjugate() * (m.a_W - kGravity));
    };
    const Vec3 a0 = q0 * force(a) + kGravity, a1 = q1 * force(b) + kGravity,
               a2 = q2 * force(c) + kGravity;
    s.T_W_B.p += h * s.v_W + h * h / 6 * (a0 + 2 * a1);
    s.v_W += h / 6 * (a0 + 4 * a1 + a2);
    s.T_W_B.q = q2;
  }
  return s;
}

TEST(Motion, RatesAndAccelerationsLeadBackToThePoses) {
  const auto motion = vir_test::briskFlight();
  const TimeNs begin = motion->begin() + fromSeconds(5), end = begin + fromSeconds(30);
  const vir::simulation::MotionState got = integrate(*motion, begin, end, fromSeconds(0.005));
  const vir::simulation::MotionState truth = motion->at(end);
  EXPECT_LT((got.T_W_B.p - truth.T_W_B.p).norm(), 1e-3);
  EXPECT_LT((got.v_W - truth.v_W).norm(), 1e-4);
  EXPECT_LT(logQuat(got.T_W_B.q.conjugate() * truth.T_W_B.q).norm(), 1e-6);
}

TEST(Motion, FliesARecordingAgainNearby) {
  const auto motion = vir_test::briskFlight();
  const Trajectory recorded = motion->sampled(200);
  vir::simulation::FlyAgainOptions o;
  o.from_s = 2;
  o.duration_s = 20;
  const vir::simulation::Motion again = vir::simulation::flyAgain(recorded, o);
  EXPECT_EQ(again.begin(), recorded.front().t + fromSeconds(2));
  EXPECT_NEAR(again.duration(), 20, 0.06);
  for (const StampedPose& s : again.sampled(33)) {
    const Pose truth = motion->poseAt(s.t);
    EXPECT_LT((s.T_W_B.p - truth.p).norm(), 5e-3);
    EXPECT_LT(logQuat(s.T_W_B.q.conjugate() * truth.q).norm(), 5e-3);
  }
}

TEST(Motion, NoiseOfARecordingIsSmoothedAway) {
  // 1 mm of white noise at 200 Hz; unsmoothed it would shake at 0.001 * sqrt(6) / 0.05^2 = 1 m/s^2.
  const auto motion = vir_test::standing(20);
  Trajectory recorded = motion->sampled(200);
  unsigned x = 1;
  for (StampedPose& s : recorded) {
    for (int axis = 0; axis < 3; ++axis) {
      x = x * 1664525u + 1013904223u;
      s.T_W_B.p[axis] += 1e-3 * std::sqrt(3.0) * (x / 2147483648.0 - 1);
    }
  }
  const vir::simulation::Motion again = vir::simulation::flyAgain(recorded, {});
  double square = 0;
  int n = 0;
  for (TimeNs t = again.begin(); t < again.end(); t += 10000000, ++n) {
    square += again.at(t).a_W.squaredNorm() / 3;
  }
  EXPECT_LT(std::sqrt(square / n), 0.6);
}

TEST(Motion, RefusesWhatCannotBeFlown) {
  EXPECT_THROW(vir::simulation::flyAgain({}, {}), std::invalid_argument);
  const Trajectory recorded = vir_test::standing(5)->sampled(20);
  vir::simulation::FlyAgainOptions o;
  o.from_s = 4.8;
  EXPECT_THROW(vir::simulation::flyAgain(recorded, o), std::invalid_argument);
  o.from_s = -3;
  EXPECT_THROW(vir::simulation::flyAgain(recorded, o), std::invalid_argument);
  const auto motion = vir_test::standing(5);
  EXPECT_THROW(motion->at(motion->end() + 1000000000), std::out_of_range);
}

TEST(Flights, AreAsLongAndFastAsSaid) {
  vir::simulation::FlightOptions o;
  for (const std::string& name : vir::simulation::flightNames()) {
    if (name == "standing") continue;
    const vir::simulation::Motion m = vir::simulation::flight(name, o);
    EXPECT_NEAR(m.pathLength(), o.length_m, 0.18 * o.length_m) << name;
    double fastest = 0, hardest = 0;
    for (TimeNs t = m.begin(); t <= m.end(); t += 10000000) {
      fastest = std::max(fastest, m.at(t).v_W.norm());
      hardest = std::max(hardest, m.at(t).a_W.norm());
    }
    EXPECT_LT(fastest, 1.6 * o.speed_mps) << name;
    EXPECT_LT(hardest, 6) << name;
  }
}

TEST(Flights, BeginAndEndAtRest) {
  vir::simulation::FlightOptions o;
  o.rest_s = 2;
  const vir::simulation::Motion m = vir::simulation::flight("corridor", o);
  for (const double s : {0.0, 1.0, 1.7, m.duration() - 1.5, m.duration()}) {
    const vir::simulation::MotionState x = m.at(m.begin() + fromSeconds(s));
    EXPECT_LT(x.v_W.norm(), 2e-3) << s;
    EXPECT_LT(x.rate_B.norm(), 2e-3) << s;
  }
  const vir::simulation::Motion still = vir::simulation::flight("standing", o);
  EXPECT_LT(still.pathLength(), 1e-9);
  EXPECT_GT(still.duration(), 20);
}

TEST(Flights, LookAheadAndStayUpright) {
  const vir::simulation::Motion m = vir::simulation::flight("corridor", {});
  for (TimeNs t = m.begin() + fromSeconds(6); t < m.end() - fromSeconds(6); t += 200000000) {
    const vir::simulation::MotionState s = m.at(t);
    EXPECT_GT((s.T_W_B.q * Vec3::UnitZ()).z(), 0.9);
    const double yaw = yawOf(s.T_W_B.R()), course = std::atan2(s.v_W.y(), s.v_W.x());
    EXPECT_GT(std::cos(yaw - course), 0.6);
  }
}

TEST(Flights, UnknownNameIsRefused) {
  EXPECT_THROW(vir::simulation::flight("looping", {}), std::invalid_argument);
}

TEST(Flights, StopAndGoStandsStill) {
  vir::simulation::FlightOptions o;
  o.stop_s = 5;
  const vir::simulation::Motion m = vir::simulation::flight("stop_and_go", o);
  // Stretches of rest after the start and before the end.
  int stops = 0;
  double longest = 0, since = -1;
  for (double s = o.rest_s + 3; s < m.duration() - o.rest_s - 4; s += 0.02) {
    const vir::simulation::MotionState x = m.at(m.begin() + fromSeconds(s));
    const bool still = x.v_W.norm() < 1e-3 && x.rate_B.norm() < 1e-3 && x.a_W.norm() < 0.02;
    if (still && since < 0) since = s;
    if (still) longest = std::max(longest, s - since);
    if (!still && since >= 0) {
      if (s - since > 4.5) ++stops;
      since = -1;
    }
  }
  EXPECT_NEAR(stops, o.length_m / 8, 2);
  EXPECT_NEAR(longest, 5, 0.5);
}

TEST(Flights, HelixAndLettersHaveTheirShapes) {
  vir::simulation::FlightOptions o;
  o.sway_m = o.sway_deg = o.height_m = 0;
  o.length_m = 75;  // four turns
  const vir::simulation::Motion helix = vir::simulation::flight("helix", o);
  EXPECT_NEAR(helix.poseAt(helix.end()).p.z(), 4.8, 0.2);
  for (const StampedPose& s : helix.sampled(5)) {
    EXPECT_LT((s.T_W_B.p - Vec3(0, 3, 0)).head<2>().norm(), 3.05);
  }
  o.length_m = 16;
  o.start_m = {10, -5, 2};
  o.start_heading_deg = 90;
  const vir::simulation::Motion letter = vir::simulation::flight("letter_i", o);
  // Along y before the turn, along -x after it.
  EXPECT_LT((letter.poseAt(letter.begin()).p - Vec3(10, -5, 2)).norm(), 0.01);
  double farthest = 0;
  for (const StampedPose& s : letter.sampled(10)) {
    EXPECT_NEAR(s.T_W_B.p.y(), -5, 0.01);
    farthest = std::min(farthest, s.T_W_B.p.x() - 10);
  }
  EXPECT_NEAR(farthest, -8, 1);
}

}  // namespace
