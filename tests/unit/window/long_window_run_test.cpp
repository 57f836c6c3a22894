/// The long window over whole walks: what ranges do to a bent chain, and what a long run costs.
#include <gtest/gtest.h>

#include <cstring>

#include "long_window_world.h"

namespace vir::window {
namespace {

using vir_test::valuesOf;
using vir_test::Walk;
using vir_test::WalkOptions;

LongWindowOptions poseWindow(int size, double scale_sigma = 0) {
  LongWindowOptions o;
  o.size = size;
  o.scale_sigma = scale_sigma;
  o.scale_walk_per_sqrt_m = scale_sigma > 0 ? 0.002 : 0;
  return o;
}

/// Walks to the end, solving at every node.
void run(const Walk& walk, LongWindow* w, int iterations = 2) {
  for (std::size_t k = 1; k < walk.truth.size(); ++k) {
    walk.advance(w, k);
    ASSERT_TRUE(w->solve(iterations, {}));
  }
}

double rms(const Walk& walk, const LongWindow& w) {
  double sum = (w.head().position() - walk.truth.back().p).squaredNorm();
  for (std::size_t k = 0; k < w.nodes().size(); ++k) {
    sum += (w.nodes()[k].position() - walk.truth[k].p).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(walk.truth.size()));
}

WalkOptions bent() {
  WalkOptions o;
  o.nodes = 150;
  o.yaw_drift = 0.005;
  o.log_scale = std::log(1.1);
  return o;
}

double deadReckoning(const Walk& walk) {
  LongWindow w(poseWindow(1000, 0.1));
  walk.start(&w);
  run(walk, &w);
  return rms(walk, w);
}

TEST(LongWindowRun, ThreeAnchorsStraightenABentChain) {
  WalkOptions o = bent();
  o.anchors = {{8, 5, 3}, {-9, 4, 1}, {1, -8, 2}};
  const Walk walk(o);
  LongWindow w(poseWindow(1000, 0.1));
  walk.start(&w);
  walk.addAnchors(&w, 0.3, 0.5);
  run(walk, &w);
  const double without = deadReckoning(walk);
  EXPECT_GT(without, 1.0) << "the drift is worth correcting";
  EXPECT_LT(rms(walk, w), 0.06);
  EXPECT_NEAR(w.head().x[3], walk.yaw_of_O.back(), 0.03);
  EXPECT_NEAR(w.head().x[4], std::log(1.1), 0.01);
  for (std::uint64_t a = 0; a < 3; ++a) {
    EXPECT_LT((w.anchor(a)->position() - o.anchors[a]).norm(), 0.15) << a;
  }
}

TEST(LongWindowRun, OneAnchorStraightensABentChain) {
  const Walk walk(bent());
  LongWindow w(poseWindow(1000, 0.1));
  walk.start(&w);
  walk.addAnchors(&w, 0.05, 0.1);
  run(walk, &w);
  // What turns about the anchor's vertical is told by the start alone and by the odometry.
  EXPECT_LT(rms(walk, w), 0.4 * deadReckoning(walk));
  EXPECT_NEAR(w.head().x[3], walk.yaw_of_O.back(), 0.2);
  EXPECT_NEAR(w.head().x[4], std::log(1.1), 0.02);
  EXPECT_LT((w.anchor(0)->position() - walk.options.anchors[0]).norm(), 0.3);
}

TEST(LongWindowRun, WithoutHeadingTheChainStaysBent) {
  WalkOptions o = bent();
  o.log_scale = 0;
  o.anchors = {{8, 5, 3}, {-9, 4, 1}, {1, -8, 2}};
  const Walk walk(o);
  LongWindowOptions stiff = poseWindow(1000);
  stiff.heading = false;
  LongWindow with(poseWindow(1000)), without(stiff);
  for (LongWindow* w : {&with, &without}) {
    walk.start(w);
    walk.addAnchors(w, 0.1, 0.2);
    run(walk, w);
  }
  EXPECT_EQ(without.frozen(), (std::vector<int>{3, 4}));
  EXPECT_EQ(with.frozen(), std::vector<int>{4});
  EXPECT_EQ(without.head().x[3], 0);
  EXPECT_LT(rms(walk, with), 0.06);
  EXPECT_GT(rms(walk, without), 2 * rms(walk, with));
}

TEST(LongWindowRun, AShortWindowNeedsNoMemoryOfTheWay) {
  // 400 nodes through windows of 20 and 400: the newest place is known about as well.
  WalkOptions o = bent();
  o.nodes = 400;
  o.yaw_drift = 0.002;
  o.anchors = {{8, 5, 3}, {-9, 4, 1}, {1, -8, 2}};
  const Walk walk(o);
  for (int size : {20, 400}) {
    LongWindow w(poseWindow(size, 0.1));
    walk.start(&w);
    walk.addAnchors(&w, 0.1, 0.3);
    run(walk, &w);
    EXPECT_LT((w.head().position() - walk.truth.back().p).norm(), 0.12) << size;
    for (std::uint64_t a = 0; a < 3; ++a) {
      EXPECT_LT((w.anchor(a)->position() - o.anchors[a]).norm(), 0.15) << size;
    }
  }
}

TEST(LongWindowRun, BoundedOverFiveThousandNodes) {
  WalkOptions o;
  o.nodes = 5001;
  o.ranges_per_node = 1;
  o.yaw_drift = 0.001;
  o.anchors = {{8, 5, 3}, {-9, 4, 1}};
  const Walk walk(o);
  for (const LongWindowMode mode : {LongWindowMode::pose, LongWindowMode::position}) {
    const char* name = mode == LongWindowMode::pose ? "pose" : "position";
    LongWindowOptions options = poseWindow(10);
    options.mode = mode;
    LongWindow w(options);
    walk.start(&w);
    walk.addAnchors(&w, 0.1, 0.3);
    std::size_t retired = 0;
    for (std::size_t k = 1; k < walk.truth.size(); ++k) {
      walk.advance(&w, k);
      ASSERT_LE(w.nodes().size(), 10u);
      for (const LongNode& n : w.takeRetired()) {
        ++retired;
        ASSERT_TRUE(Vec3(n.x).allFinite());
      }
      ASSERT_TRUE(w.solve(1, {})) << name << " at node " << k;
      if (k < 10) continue;
      ASSERT_EQ(w.jointCovariance().rows(), 5 + 8);
      ASSERT_TRUE(w.jointCovariance().allFinite()) << name << " at node " << k;
    }
    EXPECT_EQ(retired + w.nodes().size(), walk.truth.size() - 1);
    if (mode == LongWindowMode::pose) {
      EXPECT_LT((w.head().position() - walk.truth.back().p).norm(), 0.5);
      EXPECT_LT((w.anchor(0)->position() - o.anchors[0]).norm(), 0.5);
    }
    for (int i = 0; i < 13; ++i) EXPECT_GE(w.jointCovariance()(i, i), 0) << name << " " << i;
  }
}

TEST(LongWindowRun, CostTellsATruePositionFromAFalseOne) {
  const Walk walk(bent());
  LongWindow w(poseWindow(1000, 0.1));
  walk.start(&w);
  walk.addAnchors(&w, 0.1, 20);  // hardly a prior
  run(walk, &w);
  const auto before = valuesOf(w);
  const Eigen::MatrixXd joint = w.jointCovariance();
  const Vec3 truth = walk.options.anchors[0];
  Vec3 at_truth, at_mirror, far;
  const double here = w.costWithAnchorAt(0, truth, 6, {}, &at_truth);
  const double mirror = w.costWithAnchorAt(0, Vec3(8, 5, -3), 6, {}, &at_mirror);
  const double elsewhere = w.costWithAnchorAt(0, Vec3(-8, -5, 3), 6, {}, &far);
  EXPECT_LT((at_truth - truth).norm(), 0.3);
  // Both false starts either cost clearly more or find back to the truth.
  EXPECT_TRUE(mirror > here + 30 || (at_mirror - truth).norm() < 0.3) << mirror << " " << here;
  EXPECT_TRUE(elsewhere > here + 30 || (far - truth).norm() < 0.3) << elsewhere << " " << here;
  EXPECT_GT(std::max(mirror, elsewhere), here + 30);
  EXPECT_TRUE(std::isinf(w.costWithAnchorAt(9, truth, 6, {}, &far))) << "nobody knows anchor 9";
  EXPECT_EQ(valuesOf(w), before);
  EXPECT_EQ(w.jointCovariance(), joint);
  // Nor does it disturb an elimination that waits for its back-substitution.
  LongWindow other(poseWindow(1000, 0.1));
  walk.start(&other);
  walk.addAnchors(&other, 0.1, 20);
  run(walk, &other);
  for (LongWindow* x : {&w, &other}) {
    x->eliminate();
    if (x == &w) x->costWithAnchorAt(0, Vec3(8, 5, -3), 6, {}, &far);
    x->headParameters()[0] += 0.01;
    x->backSubstitute();
  }
  EXPECT_EQ(valuesOf(w), valuesOf(other));
}

TEST(LongWindowRun, TheOdometrysClaimResistsTheRanges) {
  // What `gauge_free_prior = false` is there to show.
  WalkOptions o = bent();
  o.log_scale = 0;
  o.nodes = 80;
  o.anchors = {{8, 5, 3}, {-9, 4, 1}, {1, -8, 2}};
  const Walk walk(o);
  LongWindowOptions claiming = poseWindow(1000);
  claiming.gauge_free_prior = false;
  LongWindow free(poseWindow(1000)), claims(claiming);
  double error[2] = {0, 0};
  int index = 0;
  for (LongWindow* w : {&free, &claims}) {
    walk.start(w);
    walk.addAnchors(w, 0.1, 0.2);
    for (std::size_t k = 1; k < walk.truth.size(); ++k) {
      walk.advance(w, k);
      w->setOdometryClaim(Eigen::Vector4d(1e-4, 1e-4, 1e-4, 1e-6).asDiagonal());
      ASSERT_TRUE(w->solve(2, {}));
    }
    error[index++] = (w->head().position() - walk.truth.back().p).norm();
  }
  EXPECT_LT(error[0], 0.1);
  EXPECT_GT(error[1], 3 * error[0]);
}

TEST(LongWindowRun, ByteForByteTheSameTwice) {
  WalkOptions o = bent();
  o.anchors = {{8, 5, 3}, {-9, 4, 1}};
  std::vector<double> numbers[2];
  for (std::vector<double>& out : numbers) {
    const Walk walk(o);
    LongWindow w(poseWindow(30, 0.1));
    walk.start(&w);
    walk.addAnchors(&w, 0.2, 0.5);
    run(walk, &w);
    for (const auto& block : valuesOf(w)) out.insert(out.end(), block.begin(), block.end());
    const Eigen::MatrixXd& P = w.jointCovariance();
    out.insert(out.end(), P.data(), P.data() + P.size());
  }
  ASSERT_EQ(numbers[0].size(), numbers[1].size());
  EXPECT_EQ(std::memcmp(numbers[0].data(), numbers[1].data(), numbers[0].size() * sizeof(double)),
            0);
}

TEST(LongWindowRun, BrokenRangesMakeNothingNotFinite) {
  const Walk walk(bent());
  LongWindow w(poseWindow(20, 0.1));
  walk.start(&w);
  walk.addAnchors(&w, 0.1, 0.5);
  for (std::size_t k = 1; k < 60; ++k) {
    std::vector<HeldRange> list = walk.ranges[k - 1];
    HeldRange absurd = list.front();
    absurd.range_m = k % 2 ? 1e6 : 0.001;
    list.push_back(absurd);
    absurd.anchor = 999;  // an anchor that nobody has added
    list.push_back(absurd);
    w.advance(1000000000LL * static_cast<TimeNs>(k), walk.odometry[k], list, Walk::covariance());
    w.solve(2, {});
  }
  for (const auto& block : valuesOf(w)) {
    for (double v : block) ASSERT_TRUE(std::isfinite(v));
  }
  EXPECT_LT((w.head().position() - walk.truth[59].p).norm(), 0.5);
}

}  // namespace
}  // namespace vir::window
