#include "vir/evaluation/evaluate.h"

#include <gtest/gtest.h>

#include "made_trajectories.h"

namespace vir::evaluation {
namespace {

constexpr double kDeg = 3.14159265358979323846 / 180;

/// Straight along x at 1 m/s, 10 Hz.
Trajectory line(double seconds) {
  Trajectory t;
  for (int i = 0; i <= std::lround(seconds * 10); ++i) {
    t.push_back({fromSeconds(0.1 * i), Pose(Quat::Identity(), Vec3(0.1 * i, 0, 0))});
  }
  return t;
}

EvaluationOptions unaligned() {
  EvaluationOptions options;
  options.alignment = Alignment::none;
  return options;
}

TEST(Statistics, ByHand) {
  const Statistics s = statisticsOf({4, 1, 3, 2});
  EXPECT_EQ(s.count, 4);
  EXPECT_DOUBLE_EQ(s.mean, 2.5);
  EXPECT_DOUBLE_EQ(s.median, 2.5);
  EXPECT_DOUBLE_EQ(s.rmse, std::sqrt(30.0 / 4));
  EXPECT_DOUBLE_EQ(s.p95, 3.85);  // 0.95 * 3 = 2.85 steps into 1 2 3 4
  EXPECT_EQ(s.max, 4);
  EXPECT_EQ(statisticsOf({}).rmse, 0);
  EXPECT_EQ(statisticsOf({2}).p95, 2);
}

/// Their squares are no numbers: an error of inf, or a scale of NaN, would look like a result.
TEST(Evaluate, PositionsBeyondNumbersAreAnError) {
  for (const double far : {1e308, 1e200}) {
    for (const Alignment alignment :
         {Alignment::none, Alignment::posyaw, Alignment::se3, Alignment::sim3}) {
      Trajectory estimate = line(3);
      estimate[7].T_W_B.p.y() = far;
      EvaluationOptions options;
      options.alignment = alignment;
      EXPECT_THROW(evaluate(line(3), estimate, options), EvaluationError) << far;
    }
  }
}

TEST(Evaluate, AteByHand) {
  const Trajectory ref = line(0.2);  // three poses
  Trajectory est = ref;
  est[0].T_W_B.p += Vec3(0.3, 0, 0);
  est[1].T_W_B.p += Vec3(0, 0.4, 0);
  est[2].T_W_B.p += Vec3(0, 0, 0.5);
  est[2].T_W_B.q = expQuat(Vec3(0, 3 * kDeg, 0));
  const EvaluationResult r = evaluate(ref, est, unaligned());
  EXPECT_NEAR(r.ate_position_m.rmse, std::sqrt((0.09 + 0.16 + 0.25) / 3), 1e-15);
  EXPECT_NEAR(r.ate_position_m.mean, 0.4, 1e-15);
  EXPECT_NEAR(r.ate_position_m.max, 0.5, 1e-15);
  EXPECT_NEAR(r.ate_orientation_deg.rmse, 3 / std::sqrt(3.0), 1e-12);
  EXPECT_NEAR(r.end_error_m, 0.5, 1e-15);
  // Last relative to first: (0,0,0.5) - (0.3,0,0).
  EXPECT_NEAR(r.end_to_start_m, std::sqrt(0.25 + 0.09), 1e-15);
  EXPECT_NEAR(r.path_m, 0.2, 1e-12);
  EXPECT_EQ(r.association.coverage, 1);
}

TEST(Evaluate, PerfectUpToTheAlignmentIsZero) {
  const Trajectory est = test::winding(60, 20);
  const Trajectory ref = test::seenFrom(est, Pose(Quat(rotZ(2)), Vec3(100, 50, -3)));
  const EvaluationResult r = evaluate(ref, est, {});
  EXPECT_LT(r.ate_position_m.max, 1e-10);
  EXPECT_LT(r.ate_orientation_deg.max, 1e-5);
  ASSERT_EQ(r.rpe_distance.size(), 5u);
  for (const RelativeError& e : r.rpe_distance) {
    EXPECT_GT(e.translation_m.count, 100) << e.length;
    EXPECT_LT(e.translation_m.max, 1e-10);
    EXPECT_LT(e.yaw_deg.max, 1e-5);
  }
}

TEST(Evaluate, RpeOfAScaleError) {
  Trajectory est = line(30);
  for (StampedPose& p : est) p.T_W_B.p *= 1.02;
  const EvaluationResult r = evaluate(line(30), est, unaligned());
  const double lengths[] = {1, 2, 5, 10, 20};
  for (int i = 0; i < 5; ++i) {
    const RelativeError& e = r.rpe_distance[i];
    EXPECT_EQ(e.length, lengths[i]);
    EXPECT_EQ(e.translation_m.count, 301 - 10 * lengths[i]);
    EXPECT_NEAR(e.translation_m.rmse, 0.02 * lengths[i], 1e-9);
    EXPECT_NEAR(e.translation_pct.max, 2, 1e-7);
    EXPECT_LT(e.rotation_deg.max, 1e-9);
  }
  EXPECT_NEAR(r.rpe_time.translation_m.rmse, 0.02, 1e-9);  // 1 s at 1 m/s
  EXPECT_EQ(r.rpe_time.translation_m.count, 291);
  EXPECT_EQ(r.rpe_time.translation_pct.count, 0);
  EXPECT_NEAR(r.end_to_start_m, 0.6, 1e-9);
}

TEST(Evaluate, RpeOfAYawDrift) {
  // 0.5 deg per metre; the vertical is not an axis of the body, as in EuRoC, where body x is up.
  const Quat up_is_x(rotZ(0.3) * Eigen::AngleAxisd(-90 * kDeg, Vec3::UnitY()).toRotationMatrix());
  Trajectory ref = line(30), est = ref;
  for (std::size_t i = 0; i < ref.size(); ++i) {
    ref[i].T_W_B.q = up_is_x;
    est[i].T_W_B.q = expQuat(Vec3(0, 0, 0.5 * kDeg * 0.1 * static_cast<double>(i))) * up_is_x;
  }
  const EvaluationResult r = evaluate(ref, est, unaligned());
  EXPECT_NEAR(r.rpe_distance[2].rotation_deg.rmse, 2.5, 1e-6);  // 5 m
  EXPECT_NEAR(r.rpe_distance[2].yaw_deg.rmse, 2.5, 1e-6);
}

TEST(Evaluate, RpeOfATiltErrorHasNoYaw) {
  const Trajectory ref = line(30);
  Trajectory est = ref;
  for (std::size_t i = 0; i < est.size(); ++i) {
    est[i].T_W_B.q = expQuat(Vec3(0.1 * kDeg * static_cast<double>(i), 0, 0));
  }
  const EvaluationResult r = evaluate(ref, est, unaligned());
  EXPECT_NEAR(r.rpe_distance[0].rotation_deg.rmse, 1, 1e-6);
  EXPECT_LT(r.rpe_distance[0].yaw_deg.max, 1e-9);
}

TEST(Evaluate, RpeDoesNotDependOnTheWorlds) {
  const Trajectory ref = test::winding(60, 20);
  const Trajectory est = test::noisy(ref, 0.02, 0.01, 4);
  const Pose T(expQuat(Vec3(0.2, -0.1, 2)), Vec3(5, 5, 5));
  const EvaluationResult a = evaluate(ref, est, unaligned());
  const EvaluationResult b = evaluate(ref, test::seenFrom(est, T), unaligned());
  EXPECT_GT(a.rpe_distance[2].yaw_deg.rmse, 0.1);
  EXPECT_NEAR(a.rpe_distance[2].yaw_deg.rmse, b.rpe_distance[2].yaw_deg.rmse, 1e-9);
  EXPECT_NEAR(a.rpe_distance[2].translation_m.rmse, b.rpe_distance[2].translation_m.rmse, 1e-9);
}

TEST(Evaluate, PiecesAcrossAHoleAreNotUsed) {
  const Trajectory ref = line(30);
  Trajectory est;
  for (const StampedPose& p : ref) {
    if (p.t < fromSeconds(10.05) || p.t > fromSeconds(19.95)) est.push_back(p);
  }
  const EvaluationResult r = evaluate(ref, est, unaligned());
  // 1 m: 91 pieces on each side of the hole; those that would end beyond it overshoot.
  EXPECT_EQ(r.rpe_distance[0].translation_m.count, 182);
  EXPECT_NEAR(r.association.coverage, 20.0 / 30, 1e-9);
}

TEST(Evaluate, LongerThanThePathIsNoPiece) {
  const EvaluationResult r = evaluate(line(3), line(3), {});
  EXPECT_GT(r.rpe_distance[1].translation_m.count, 0);
  EXPECT_EQ(r.rpe_distance[2].translation_m.count, 0);
  EXPECT_EQ(r.rpe_distance[2].translation_m.rmse, 0);
}

TEST(Evaluate, StandingStillIsWellDefined) {
  Trajectory ref = line(10), est = line(10);
  for (StampedPose& p : ref) p.T_W_B.p = Vec3(1, 2, 3);
  for (StampedPose& p : est) p.T_W_B.p = Vec3(0, 0, 0);
  for (const Alignment a : {Alignment::posyaw, Alignment::se3, Alignment::sim3}) {
    EvaluationOptions options;
    options.alignment = a;
    const EvaluationResult r = evaluate(ref, est, options);
    EXPECT_LT(r.ate_position_m.max, 1e-12) << name(a);
    EXPECT_LT(r.ate_orientation_deg.max, 1e-5) << name(a);
    EXPECT_EQ(r.path_m, 0);
    EXPECT_EQ(r.rpe_distance[0].translation_m.count, 0);
    EXPECT_NE(r.transform.note, "") << name(a);
  }
}

std::string errorOf(const Trajectory& ref, const Trajectory& est) {
  try {
    evaluate(ref, est, {});
  } catch (const EvaluationError& e) {
    return e.what();
  }
  return "";
}

TEST(Evaluate, SaysWhyItCannot) {
  EXPECT_NE(errorOf({}, line(1)).find("reference holds no pose"), std::string::npos);
  EXPECT_NE(errorOf(line(1), {}).find("estimate holds no pose"), std::string::npos);
  EXPECT_NE(errorOf(line(1), {line(1)[0], line(1)[1]}).find("2 of 2 poses"), std::string::npos);
  Trajectory later = line(1);
  for (StampedPose& p : later) p.t += fromSeconds(100);
  const std::string text = errorOf(line(1), later);
  EXPECT_NE(text.find("0 of 11 poses"), std::string::npos) << text;
  EXPECT_NE(text.find("same clock"), std::string::npos) << text;
}

TEST(Evaluate, TheWordsSayHowItWasCompared) {
  EXPECT_NE(describeComparison(unaligned()).find("not aligned"), std::string::npos);
  EXPECT_NE(describeComparison({}).find("position and yaw"), std::string::npos);
  EXPECT_NE(describeComparison({}).find("0.1 s"), std::string::npos);
}

}  // namespace
}  // namespace vir::evaluation
