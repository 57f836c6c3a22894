/// Numbers that are no measurements: an exception, or an answer of numbers.
#include <gtest/gtest.h>

#include <cmath>

#include "made_trajectories.h"
#include "vir/evaluation/evaluate.h"
#include "vir/evaluation/nees.h"
#include "vir_test_extremes.h"

namespace vir::evaluation {
namespace {

void expectNumbers(const Statistics& s) {
  for (const double x : {s.rmse, s.mean, s.median, s.p95, s.max}) EXPECT_TRUE(std::isfinite(x));
}

void expectNumbersOrNothing(const Trajectory& reference, const Trajectory& estimate) {
  for (const Alignment alignment :
       {Alignment::none, Alignment::posyaw, Alignment::se3, Alignment::sim3}) {
    EvaluationOptions options;
    options.alignment = alignment;
    try {
      const EvaluationResult r = evaluate(reference, estimate, options);
      expectNumbers(r.ate_position_m);
      expectNumbers(r.ate_orientation_deg);
      expectNumbers(r.rpe_time.translation_m);
      expectNumbers(r.rpe_time.rotation_deg);
      for (const RelativeError& e : r.rpe_distance) {
        expectNumbers(e.translation_m);
        expectNumbers(e.translation_pct);
        expectNumbers(e.yaw_deg);
      }
      for (const double x :
           {r.path_m, r.end_error_m, r.end_to_start_m, r.best_scale, r.transform.scale}) {
        EXPECT_TRUE(std::isfinite(x));
      }
    } catch (const EvaluationError&) {
    }
  }
}

TEST(ExtremeNumbers, Positions) {
  const Trajectory good = test::winding(3, 20);
  test::forExtremeVectors(good[30].T_W_B.p, [&](const Vec3& p) {
    SCOPED_TRACE(testing::Message() << p.transpose());
    Trajectory one = good, all = good;
    one[30].T_W_B.p = p;
    for (StampedPose& pose : all) pose.T_W_B.p = p;
    expectNumbersOrNothing(good, one);
    expectNumbersOrNothing(one, good);
    expectNumbersOrNothing(good, all);
    expectNumbersOrNothing(all, good);
    expectNumbersOrNothing(all, all);
  });
}

TEST(ExtremeNumbers, Scales) {
  const Trajectory good = test::winding(3, 20);
  for (const double x : test::extremes()) {
    SCOPED_TRACE(x);
    const Trajectory scaled = test::seenFrom(good, Pose(), x);
    expectNumbersOrNothing(good, scaled);
    expectNumbersOrNothing(scaled, good);
    expectNumbersOrNothing(scaled, scaled);
  }
}

TEST(ExtremeNumbers, Consistency) {
  for (const double x : test::extremes()) {
    for (const double y : test::extremes()) {
      double value = -1;
      const bool says = nees(Vec3(x, 0.1, 0), Mat3(Vec3(y, 1, 1).asDiagonal()), &value);
      EXPECT_TRUE(std::isfinite(value) && value >= 0) << x << ", variance " << y;
      EXPECT_TRUE(says || value == 0);
    }
  }
}

}  // namespace
}  // namespace vir::evaluation
