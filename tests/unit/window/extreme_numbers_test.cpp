/// Numbers that are no measurements: a window refuses them, or is not usable, or has states that
/// are numbers; it never hangs.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <stdexcept>

#include "long_window_world.h"
#include "vir_test_extremes.h"
#include "window_driver.h"

namespace vir::window {
namespace {

using test::extremes;
using vir_test::Walk;
using vir_test::WalkOptions;
using vir_test::WindowDriver;
using Features = std::vector<vision::FeatureObservation>;

void expectNumbers(const ShortWindow& window) {
  for (const State& s : window.states()) {
    EXPECT_TRUE(s.T_W_B.p.allFinite() && s.T_W_B.q.coeffs().allFinite());
    EXPECT_TRUE(s.v.allFinite() && s.bg.allFinite() && s.ba.allFinite());
  }
  for (const Landmark& l : window.landmarks()) EXPECT_TRUE(l.p_W.allFinite());
}

/// A window of some keyframes; what is spoilt comes with the image after them.
class SpoiltWindow {
 public:
  SpoiltWindow() : d_(vir_test::circling, 1, WindowOptions(), 0.8) {
    d_.start(d_.scene.truth(d_.t), StartPrior());
    for (int k = 0; k < 5; ++k) d_.step(0.15);
  }
  /// Whatever happened, the states of the window, if it is usable, are numbers: then and later.
  void goOn(int images = 3) {
    for (int k = 0; k < images; ++k) {
      try {
        d_.step(0.15);
      } catch (const std::invalid_argument&) {
        return;
      } catch (const std::runtime_error&) {
        return;
      }
      d_.spoil = {};
      if (!d_.last.usable) return;
      expectNumbers(d_.window);
    }
  }
  WindowDriver d_;
};

TEST(ExtremeNumbers, Sights) {
  for (const double value : extremes()) {
    for (int what = 0; what < 6; ++what) {
      SCOPED_TRACE(testing::Message() << value << " in part " << what);
      SpoiltWindow w;
      w.d_.spoil = [&](Features* features) {
        vision::FeatureObservation& o = features->at(features->size() / 2);
        if (what == 0) o.px.x() = value;
        if (what == 1) o.bearing.y() = value;
        if (what == 2) o.bearing.setConstant(value);
        if (what == 3) o.dpx_dbearing.setConstant(value);
        if (what == 4) o.bearing_rate.setConstant(value);
        if (what == 5) {
          for (vision::FeatureObservation& all : *features) all.bearing.setConstant(value);
        }
      };
      w.goOn();
    }
  }
}

TEST(ExtremeNumbers, PredictedStates) {
  for (const double value : extremes()) {
    for (int what = 0; what < 5; ++what) {
      SCOPED_TRACE(testing::Message() << value << " in part " << what);
      SpoiltWindow w;
      const State from = w.d_.window.newest();
      w.d_.t += fromSeconds(0.15);
      w.d_.feedImu();
      imu::Preintegration link = w.d_.imu.integrate(from.t, w.d_.t, w.d_.noise, from.bg, from.ba);
      State s = predict(from, link, 9.81, w.d_.t);
      if (what == 0) s.T_W_B.p.x() = value;
      if (what == 1) s.T_W_B.q.coeffs() = Eigen::Vector4d(value, 0, 0, 1).normalized();
      if (what == 2) s.v.y() = value;
      if (what == 3) s.bg.z() = value;
      if (what == 4) s.ba.setConstant(value);
      w.d_.window.resect(s.T_W_B, w.d_.observe(), 5);
      w.d_.window.push(s, std::move(link), w.d_.observe(), false);
      w.d_.window.keepNewest();
      w.d_.window.triangulate();
      const SolveSummary solved = w.d_.window.optimise(5);
      if (!solved.usable) continue;
      expectNumbers(w.d_.window);
      w.d_.window.rejectOutliers();
      w.d_.window.updateCovariance();
      w.d_.window.slide(true);
      w.goOn();
    }
  }
}

TEST(ExtremeNumbers, RangesOfTheShortWindow) {
  for (const double value : extremes()) {
    for (int what = 0; what < 5; ++what) {
      SCOPED_TRACE(testing::Message() << value << " in part " << what);
      SpoiltWindow w;
      Eigen::Vector4d mean(4, 3, 2, 0);
      if (what == 4) mean[1] = value;
      w.d_.long_window.addAnchor(3, mean, Eigen::Vector4d(0.1, 0.1, 0.1, 1e-4).asDiagonal());
      HeldRange r;
      r.t = w.d_.t;
      r.anchor = 3;
      r.range_m = (Vec3(4, 3, 2) - w.d_.window.newest().T_W_B.p).norm();
      if (what == 0) r.range_m = value;
      if (what == 1) r.sigma_m = value;
      if (what == 2) r.motion.setConstant(value);
      if (what == 3) r.lever.x() = value;
      w.d_.pushed = [&] { w.d_.window.addRange(r); };
      w.goOn();
    }
  }
}

TEST(ExtremeNumbers, Beginnings) {
  using Member = double StartPrior::*;
  for (const Member member :
       {&StartPrior::position_m, &StartPrior::yaw_rad, &StartPrior::tilt_rad,
        &StartPrior::velocity_mps, &StartPrior::bias_gyro, &StartPrior::bias_acc}) {
    for (const double value : extremes()) {
      SCOPED_TRACE(value);
      WindowDriver d(vir_test::circling, 1, WindowOptions(), 0.8);
      StartPrior prior;
      prior.*member = value;
      try {
        d.start(d.scene.truth(d.t), prior);
      } catch (const std::invalid_argument&) {
        continue;
      }
      for (int k = 0; k < 4; ++k) {
        d.step(0.15);
        if (!d.last.usable) break;
        expectNumbers(d.window);
      }
    }
  }
}

/// A walk in which `spoil` changes what the 20th node brings.
void walkWith(const std::function<void(Pose*, std::vector<HeldRange>*, Eigen::Matrix4d*)>& spoil) {
  WalkOptions options;
  options.nodes = 30;
  const Walk walk(options);
  LongWindow w{LongWindowOptions()};
  walk.start(&w);
  walk.addAnchors(&w, 0.1, 0.5);
  for (std::size_t k = 1; k < 30; ++k) {
    Pose T_O_B = walk.odometry[k];
    std::vector<HeldRange> ranges = walk.ranges[k - 1];
    Eigen::Matrix4d covariance = Walk::covariance();
    if (k == 20) spoil(&T_O_B, &ranges, &covariance);
    try {
      w.advance(1000000000LL * static_cast<TimeNs>(k), T_O_B, ranges, covariance);
    } catch (const std::invalid_argument&) {
      return;
    }
    if (!w.solve(2, {})) return;
    EXPECT_TRUE(w.head().position().allFinite());
    for (const LongNode& n : w.nodes()) EXPECT_TRUE(n.position().allFinite());
    for (const auto& [id, a] : w.anchors()) EXPECT_TRUE(a.position().allFinite());
    EXPECT_TRUE(w.jointCovariance().allFinite());
  }
}

TEST(ExtremeNumbers, NodesOfTheLongWindow) {
  for (const double value : extremes()) {
    SCOPED_TRACE(value);
    using Ranges = std::vector<HeldRange>;
    walkWith([&](Pose* T, Ranges*, Eigen::Matrix4d*) { T->p.x() = value; });
    walkWith([&](Pose* T, Ranges*, Eigen::Matrix4d*) { T->p.setConstant(value); });
    walkWith([&](Pose* T, Ranges*, Eigen::Matrix4d*) { T->q.z() = value; });
    walkWith([&](Pose*, Ranges*, Eigen::Matrix4d* C) { (*C)(1, 1) = value; });
    walkWith([&](Pose*, Ranges*, Eigen::Matrix4d* C) { C->setConstant(value); });
    walkWith([&](Pose*, Ranges* r, Eigen::Matrix4d*) { r->front().range_m = value; });
    walkWith([&](Pose*, Ranges* r, Eigen::Matrix4d*) { r->front().sigma_m = value; });
    walkWith([&](Pose*, Ranges* r, Eigen::Matrix4d*) { r->front().motion.setConstant(value); });
    walkWith([&](Pose*, Ranges* r, Eigen::Matrix4d*) { r->front().lever.z() = value; });
  }
}

TEST(ExtremeNumbers, MergedRanges) {
  for (const double value : extremes()) {
    std::vector<HeldRange> ranges(40);
    for (std::size_t i = 0; i < ranges.size(); ++i) {
      ranges[i].t = static_cast<TimeNs>(i);
      ranges[i].range_m = i == 7 ? value : 5;
      ranges[i].sigma_m = i == 9 ? value : 0.1;
    }
    mergeRanges(&ranges, 4);
    EXPECT_GE(ranges.size(), 1u) << value;
    EXPECT_LE(ranges.size(), 4u) << value;
  }
}

TEST(ExtremeNumbers, InformationOfWhatIsMarginalised) {
  for (const double value : extremes()) {
    for (int what = 0; what < 3; ++what) {
      SCOPED_TRACE(testing::Message() << value << " in part " << what);
      double x[4] = {1, 2, 3, 4};
      NormalEquations eq;
      eq.blocks = {{x, 4, 4, 0}};
      eq.H = Eigen::Matrix4d::Identity();
      eq.b = Eigen::Vector4d::Zero();
      if (what == 0) eq.H(1, 1) = value;
      if (what == 1) eq.H.setConstant(value);
      if (what == 2) eq.b[2] = value;
      const factors::LinearPrior prior = toPrior(eq);
      const Eigen::MatrixXd covariance = covarianceOf(eq);
      const bool squarable = std::isfinite(value) && std::abs(value) <= 1e18;
      if (!squarable) continue;
      EXPECT_TRUE(prior.J.allFinite() && prior.r0.allFinite());
      EXPECT_TRUE(covariance.allFinite());
    }
  }
}

}  // namespace
}  // namespace vir::window
