/// Numbers that are no measurements: an exception, or an answer of numbers.
#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "vir/ranging/anchor_initialization.h"
#include "vir/ranging/gaussian_process.h"
#include "vir/ranging/range_calibration.h"
#include "vir/ranging/range_correlation.h"
#include "vir/ranging/range_gate.h"
#include "vir_test_extremes.h"

namespace vir::ranging {
namespace {

using test::extremes;

TEST(ExtremeNumbers, RobustLoss) {
  for (const double delta : extremes()) {
    RobustRange robust;
    robust.huber_delta = robust.nlos_delta = std::isfinite(delta) ? delta : 1.5;
    for (const double r : extremes()) {
      const RobustRange::Value v = robust.evaluate(r);
      EXPECT_TRUE(std::isfinite(v.e) && std::isfinite(v.de_dr) && std::isfinite(v.weight))
          << "delta " << delta << ", residual " << r;
    }
  }
}

TEST(ExtremeNumbers, Gate) {
  for (const double residual : extremes()) {
    for (const double variance : extremes()) {
      RangeGate gate;
      for (int i = 0; i < 50; ++i) {
        const RangeDecision decision = gate.check(TimeNs(i) * 100'000'000, residual, variance, i);
        EXPECT_TRUE(std::isfinite(residual) || decision == RangeDecision::invalid ||
                    decision == RangeDecision::too_long || decision == RangeDecision::too_short);
      }
      // A good one afterwards is not locked out.
      gate.reset();
      EXPECT_EQ(gate.check(10'000'000'000, 0.01, 0.01, 60), RangeDecision::accepted);
    }
  }
}

TEST(ExtremeNumbers, Correlation) {
  for (const double x : extremes()) {
    std::vector<RangeResidual> residuals;
    for (int i = 0; i < 100; ++i) {
      residuals.push_back({TimeNs(i) * 100'000'000, i % 7 == 3 ? x : 0.05 * std::sin(i), 0.1});
    }
    residuals[50].sigma_m = x;
    const RangeCorrelation c = rangeCorrelation(residuals);
    EXPECT_TRUE(std::isfinite(c.variance_factor) && c.variance_factor >= 1) << x;
    EXPECT_TRUE(std::isfinite(c.lag_one) && std::isfinite(c.correlation_factor)) << x;
    withoutSlowPart(residuals, 6);
  }
}

/// A path of some metres past an anchor, with one number spoilt, or all.
TEST(ExtremeNumbers, Anchors) {
  for (const double x : extremes()) {
    for (int what = 0; what < 6; ++what) {
      std::vector<AntennaRange> ranges;
      for (int i = 0; i < 60; ++i) {
        const double s = 0.1 * i;
        AntennaRange r;
        r.p_W = Vec3(3 * std::sin(s), 2 * std::cos(0.7 * s), 0.5 * s);
        r.range_m = (r.p_W - Vec3(4, 3, 1)).norm();
        if (what == 0 && i == 30) r.range_m = x;
        if (what == 1) r.range_m = x;
        if (what == 2 && i == 30) r.p_W.y() = x;
        if (what == 3) r.p_W = Vec3::Constant(x);
        if (what == 4) r.sigma_m = x;
        if (what == 5) r.p_W.z() = x;
        ranges.push_back(r);
      }
      SCOPED_TRACE(testing::Message() << "spoilt " << what << " with " << x);
      const AnchorInitialization found = initializeAnchor(ranges, {});
      for (const AnchorSolution& s : found.solutions) {
        EXPECT_TRUE(s.p_W.allFinite());
      }
    }
  }
}

TEST(ExtremeNumbers, Calibration) {
  for (const double x : extremes()) {
    for (const bool distance : {false, true}) {
      std::vector<CalibrationSample> samples;
      std::vector<double> xs, ys;
      for (int i = 0; i < 60; ++i) {
        CalibrationSample s{TimeNs(i) * 100'000'000, 0, 1 + 0.1 * i, 0.02 * std::sin(0.3 * i)};
        if (i == 20) (distance ? s.distance_m : s.residual_m) = x;
        samples.push_back(s);
        xs.push_back(s.distance_m);
        ys.push_back(s.residual_m);
      }
      SCOPED_TRACE(testing::Message() << x << (distance ? " as distance" : " as residual"));
      try {
        const RangeCalibration c = calibrateRangeBias(samples);
        EXPECT_TRUE(std::isfinite(c.sigma_m));
        EXPECT_TRUE(std::isfinite(c.model.at(3).mean_m));
      } catch (const std::invalid_argument&) {
      } catch (const std::runtime_error&) {
      }
    }
  }
}

}  // namespace
}  // namespace vir::ranging
