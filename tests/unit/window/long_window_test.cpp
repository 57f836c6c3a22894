/// The long window's algebra: elimination, marginalisation and bookkeeping.
#include "vir/window/long_window.h"

#include <gtest/gtest.h>

#include "long_window_world.h"

namespace vir::window {

/// What a failed test shows.
void PrintTo(LongWindowMode mode, std::ostream* out) {
  *out << (mode == LongWindowMode::pose ? "pose" : "position");
}

namespace {

using vir_test::Batch;
using vir_test::largestDifference;
using vir_test::valuesOf;
using vir_test::Walk;
using vir_test::WalkOptions;

LongWindowOptions optionsFor(LongWindowMode mode, int size, double scale_sigma = 0) {
  LongWindowOptions o;
  o.mode = mode;
  o.size = size;
  o.scale_sigma = scale_sigma;
  o.scale_walk_per_sqrt_m = scale_sigma > 0 ? 0.005 : 0;
  return o;
}

WalkOptions threeAnchors(int nodes) {
  WalkOptions o;
  o.nodes = nodes;
  o.anchors = {{8, 5, 3}, {-9, 4, 1}, {1, -8, 2}};
  return o;
}

class LongWindowModes : public ::testing::TestWithParam<LongWindowMode> {};
INSTANTIATE_TEST_SUITE_P(Modes, LongWindowModes,
                         ::testing::Values(LongWindowMode::pose, LongWindowMode::position));

void expectOneStepOfTheDenseProblem(LongWindowMode mode, bool differences) {
  for (double scale_sigma : {0.0, 0.1}) {
    WalkOptions o = threeAnchors(25);
    o.differences = differences;
    const Walk walk(o);
    LongWindow w(optionsFor(mode, 1000, scale_sigma));
    walk.start(&w);
    walk.addAnchors(&w, 0.3, 0.5);
    for (std::size_t k = 1; k < walk.truth.size(); ++k) walk.advance(&w, k);
    // The head off its odometry, so that the last edges have residuals too.
    for (int i = 0; i < 3; ++i) w.headParameters()[i] += 0.02 * (i + 1);
    Batch batch(&w, {}, walk.truth[0]);
    const Eigen::VectorXd expected = batch.step();
    batch.apply(expected);

    const NormalEquations eq = w.eliminate();
    ASSERT_EQ(eq.H.rows(), 5 + 3 * 4);
    EXPECT_LT((eq.H - eq.H.transpose()).norm(), 1e-9 * eq.H.norm());
    const int n = static_cast<int>(eq.H.rows());
    // The marginal of the dense problem for head and anchors.
    const Eigen::MatrixXd P = batch.covariance.bottomRightCorner(n, n);
    EXPECT_LT((eq.H.inverse() - P).norm(), 1e-6 * P.norm());
    const Eigen::VectorXd d = -eq.H.ldlt().solve(eq.b);
    EXPECT_LT((d - expected.tail(n)).norm(), 1e-8 * (1 + expected.norm()));
    for (int i = 0; i < 5; ++i) w.headParameters()[i] += d[i];
    for (std::uint64_t a = 0; a < 3; ++a) {
      for (int i = 0; i < 4; ++i) w.anchor(a)->x[i] += d[5 + 4 * static_cast<int>(a) + i];
    }
    w.backSubstitute();
    EXPECT_LT(largestDifference(valuesOf(w), batch.x), 1e-8) << "scale sigma " << scale_sigma;
  }
}

TEST_P(LongWindowModes, OneStepIsThatOfTheDenseProblem) {
  expectOneStepOfTheDenseProblem(GetParam(), false);
}

TEST_P(LongWindowModes, OneStepIsThatOfTheDenseProblemWithDifferencesOfRanges) {
  expectOneStepOfTheDenseProblem(GetParam(), true);
}

TEST_P(LongWindowModes, SolvedIsTheDenseBatchSolution) {
  // Little drift: position links cannot bend, and residuals in the tails converge slowly.
  WalkOptions o = threeAnchors(30);
  o.yaw_drift = 0.0005;
  const Walk walk(o);
  LongWindow w(optionsFor(GetParam(), 1000));
  walk.start(&w);
  walk.addAnchors(&w, 0.3, 0.5);
  for (std::size_t k = 1; k < walk.truth.size(); ++k) walk.advance(&w, k);
  // With little change per step, the window stops; the batch goes on from there and finds nothing.
  for (int k = 0; k < 5; ++k) ASSERT_TRUE(w.solve(30, walk.lastRanges()));
  Batch batch(&w, walk.lastRanges(), walk.truth[0]);
  batch.solve(10);
  EXPECT_LT(largestDifference(valuesOf(w), batch.x), 5e-3);
  const Eigen::MatrixXd& P = w.jointCovariance();
  batch.step();
  for (int i = 0; i < 17; ++i) {
    const double dense = batch.covariance(batch.offsetOf(batch.nodes() - 1) + i,
                                          batch.offsetOf(batch.nodes() - 1) + i);
    const bool held = GetParam() == LongWindowMode::position ? i == 3 || i == 4 : i == 4;
    if (held) {
      EXPECT_EQ(P(i, i), 0);
    } else {
      EXPECT_NEAR(std::sqrt(P(i, i) / dense), 1, 0.02) << i;
    }
  }
}

TEST_P(LongWindowModes, MarginalisedNodesStillCount) {
  // Nothing is solved in between, so that both windows are linearised at the same values: the first
  // step must agree to the last digits.
  const Walk walk(threeAnchors(60));
  LongWindow small(optionsFor(GetParam(), 5)), large(optionsFor(GetParam(), 1000));
  for (LongWindow* w : {&small, &large}) {
    walk.start(w);
    walk.addAnchors(w, 0.05, 0.5);
    for (std::size_t k = 1; k < walk.truth.size(); ++k) walk.advance(w, k);
  }
  ASSERT_EQ(small.nodes().size(), 5u);
  ASSERT_EQ(large.nodes().size(), walk.truth.size() - 1);
  const NormalEquations a = small.eliminate(), b = large.eliminate();
  EXPECT_LT((a.H - b.H).norm(), 1e-7 * b.H.norm());
  EXPECT_LT((a.b - b.b).norm(), 1e-7 * b.b.norm());
  const Eigen::VectorXd da = a.H.ldlt().solve(a.b), db = b.H.ldlt().solve(b.b);
  EXPECT_LT((da - db).norm(), 1e-6 * (1 + db.norm()));
}

TEST(LongWindow, MarginalisedAndSolvedAllTheTime) {
  // With little drift the values at which nodes are marginalised are good ones.
  WalkOptions o = threeAnchors(120);
  o.yaw_drift = 0.0005;
  const Walk walk(o);
  LongWindow small(optionsFor(LongWindowMode::pose, 5)),
      large(optionsFor(LongWindowMode::pose, 1000));
  for (LongWindow* w : {&small, &large}) {
    walk.start(w);
    walk.addAnchors(w, 0.05, 0.2);
    for (std::size_t k = 1; k < walk.truth.size(); ++k) {
      walk.advance(w, k);
      ASSERT_TRUE(w->solve(2, {}));
    }
    EXPECT_LT((w->head().position() - walk.truth.back().p).norm(), 0.08);
  }
  // Far below the standard deviations of either (2 to 5 cm).
  EXPECT_LT((small.head().position() - large.head().position()).norm(), 0.01);
  for (std::uint64_t a = 0; a < 3; ++a) {
    EXPECT_LT((small.anchor(a)->position() - large.anchor(a)->position()).norm(), 0.01) << a;
  }
}

TEST(LongWindow, NoneKeepsNoNodes) {
  const Walk walk(threeAnchors(40));
  LongWindow none(optionsFor(LongWindowMode::none, 100)),
      large(optionsFor(LongWindowMode::pose, 100));
  for (LongWindow* w : {&none, &large}) {
    walk.start(w);
    walk.addAnchors(w, 0.05, 0.5);
    for (std::size_t k = 1; k < walk.truth.size(); ++k) {
      walk.advance(w, k);
      if (w == &none) {
        ASSERT_TRUE(w->nodes().empty());
      }
    }
  }
  const NormalEquations a = none.eliminate(), b = large.eliminate();
  EXPECT_LT((a.H - b.H).norm(), 1e-7 * b.H.norm());
  EXPECT_LT((a.b - b.b).norm(), 1e-7 * b.b.norm());
  EXPECT_EQ(none.takeRetired().size(), walk.truth.size() - 1);
  EXPECT_TRUE(none.takeRetired().empty());
}

TEST_P(LongWindowModes, HeadMovedSpreadsTheShift) {
  const Walk walk(threeAnchors(20));
  LongWindow w(optionsFor(GetParam(), 100));
  walk.start(&w);
  for (std::size_t k = 1; k < walk.truth.size(); ++k) walk.advance(&w, k);
  w.headParameters()[3] = 0;
  const auto before = valuesOf(w);
  const Pose T_O = w.head().T_O_B;
  const Vec3 shift(0.2, -0.1, 0.05), somewhere_O(1, 2, 3);
  const Vec3 somewhere_W = w.pointToWorld(somewhere_O);
  w.headMoved(77, Pose(T_O.q, T_O.p + shift));
  const auto after = valuesOf(w);
  EXPECT_EQ(w.head().t, 77);
  EXPECT_EQ(before.front(), after.front()) << "the first node stays";
  double last = 0;
  for (std::size_t k = 0; k < after.size(); ++k) {
    const Vec3 moved = Vec3(after[k].data()) - Vec3(before[k].data());
    const double part = moved.dot(shift) / shift.squaredNorm();
    EXPECT_LT((moved - part * shift).norm(), 1e-12);
    EXPECT_GE(part, last - 1e-12);
    EXPECT_LT(part - last, 0.1) << "evenly, as all edges are alike";
    last = part;
  }
  EXPECT_NEAR(last, 1, 1e-12);
  EXPECT_LT((w.toWorld(w.head().T_O_B).p - w.head().position()).norm(), 1e-12);
  EXPECT_LT((w.pointToWorld(somewhere_O) - somewhere_W).norm(), 1e-12)
      << "the odometry moved, not the world";
  // The edges moved with it: nothing pulls back.
  ASSERT_TRUE(w.solve(3, {}));
  EXPECT_LT(largestDifference(valuesOf(w), after), 1e-9);
}

TEST(LongWindow, AStretchThatWasLostTiesAsLooselyAsIsKnown) {
  for (const LongWindowMode mode : {LongWindowMode::pose, LongWindowMode::position}) {
    SCOPED_TRACE(::testing::PrintToString(mode));
    for (const bool conditional : {true, false}) {
      LongWindowOptions o = optionsFor(mode, 100);
      o.conditional_edges = conditional;
      const Walk walk(threeAnchors(20));
      LongWindow w(o);
      walk.start(&w);
      const auto sigma = [&] {
        EXPECT_TRUE(w.solve(1, {}));
        return std::sqrt(w.jointCovariance()(0, 0));
      };
      for (std::size_t k = 1; k < 8; ++k) walk.advance(&w, k);
      EXPECT_LT(sigma(), 0.1);
      w.advance(9000000000, walk.odometry[8], {}, Eigen::Vector4d(4, 4, 4, 0.01).asDiagonal(),
                NodeTie::lost);
      const double lost = sigma();
      EXPECT_NEAR(lost, 2 * o.edge_noise_scale, 0.1);
      // Nor is it tied by what comes afterwards, which is as closely tied as ever.
      for (std::size_t k = 9; k < 14; ++k) walk.advance(&w, k);
      EXPECT_NEAR(sigma(), lost, 0.1);
    }
  }
}

TEST(LongWindow, AnAntennaKeepsItsLeverArmWhateverTheScale) {
  LongWindow w(optionsFor(LongWindowMode::pose, 100, 0.1));
  w.start(0, Pose(Quat::Identity(), Vec3(1, 1, 0)), Pose(Quat::Identity(), Vec3(5, 6, 7)), 0.1,
          0.1);
  w.headParameters()[3] = M_PI / 2;
  w.headParameters()[4] = std::log(2.0);
  // The body 2 m along O's x from the head: 1 m along W's y. The lever arm points along O's y: W's
  // -x.
  EXPECT_LT((w.antennaToWorld(Vec3(3, 1.5, 0), Vec3(0, 0.5, 0)) - Vec3(4.5, 7, 7)).norm(), 1e-12);
  HeldRange r;
  r.motion = Vec3(2, 0, 0);
  r.lever = Vec3(0, 0.5, 0);
  std::vector<HeldRange> held;
  addHeldInWorld(
      w.head(), {HeldRange(), r}, [](const auto& h) { return h.lever.y() > 0; }, &held);
  ASSERT_EQ(held.size(), 1u);
  EXPECT_LT((held[0].motion - Vec3(4.5, 7, 7)).norm() + held[0].lever.norm(), 1e-12);
}

TEST(LongWindow, ToWorldTurnsAndShrinks) {
  LongWindow w(optionsFor(LongWindowMode::pose, 100, 0.1));
  w.start(0, Pose(Quat::Identity(), Vec3(1, 1, 0)), Pose(Quat(rotZ(0.5)), Vec3(5, 6, 7)), 0.1, 0.1);
  EXPECT_NEAR(w.head().x[3], 0.5, 1e-12);
  w.headParameters()[3] = M_PI / 2;
  w.headParameters()[4] = std::log(2.0);
  EXPECT_LT((w.turnToWorld(Vec3(2, 0, 4)) - Vec3(0, 1, 2)).norm(), 1e-12);
  EXPECT_LT((w.pointToWorld(Vec3(3, 1, 4)) - Vec3(5, 7, 9)).norm(), 1e-12);
  const Pose T = w.toWorld(Pose(expQuat(Vec3(0.2, 0, 0)), Vec3(3, 1, 4)));
  EXPECT_LT((T.R() - rotZ(M_PI / 2) * expSO3(Vec3(0.2, 0, 0))).norm(), 1e-12);
}

TEST(LongWindow, RemoveAnchorKeepsTheRest) {
  const Walk walk(threeAnchors(60));
  LongWindow w(optionsFor(LongWindowMode::pose, 8));
  walk.start(&w);
  walk.addAnchors(&w, 0.1, 0.5);
  for (std::size_t k = 1; k < walk.truth.size(); ++k) {
    walk.advance(&w, k);
    ASSERT_TRUE(w.solve(2, {}));
  }
  const Vec3 head = w.head().position(), other = w.anchor(2)->position();
  const double sigma = std::sqrt(w.jointCovariance()(5 + 8, 5 + 8));
  EXPECT_EQ(w.columnOf(1), 9);
  w.removeAnchor(1);
  EXPECT_EQ(w.anchor(1), nullptr);
  EXPECT_EQ(w.anchors().size(), 2u);
  EXPECT_EQ(w.head().position(), head);
  ASSERT_TRUE(w.solve(5, {}));
  EXPECT_EQ(w.columnOf(1), -1);
  EXPECT_EQ(w.columnOf(2), 9);
  EXPECT_EQ(w.jointCovariance().rows(), 5 + 8);
  // Its ranges in the window are gone, so the rest settles a little, within what it knows.
  EXPECT_LT((w.head().position() - head).norm(), 0.12);
  EXPECT_LT((w.anchor(2)->position() - other).norm(), 0.15);
  EXPECT_LT(std::sqrt(w.jointCovariance()(9, 9)), 2 * sigma) << "what was learnt of it stays";
  w.removeAnchor(77);  // nobody knows it
  EXPECT_EQ(w.anchors().size(), 2u);
}

TEST(LongWindow, AFixedAnchorStays) {
  for (int size : {5, 1000}) {
    const Walk walk(threeAnchors(60));
    LongWindow w(optionsFor(LongWindowMode::pose, size));
    walk.start(&w);
    walk.addAnchors(&w, 0.1, 0.5);
    std::vector<double> held;
    for (std::size_t k = 1; k < walk.truth.size(); ++k) {
      walk.advance(&w, k);
      if (k == 30) {
        // Found to be somewhere it is not quite, after nodes have been marginalised.
        w.anchor(1)->x[0] += 0.1;
        w.anchor(1)->fixed = true;
        held.assign(w.anchor(1)->x, w.anchor(1)->x + 4);
      }
      ASSERT_TRUE(w.solve(2, {}));
      if (k < 30) continue;
      const std::vector<double> now(w.anchor(1)->x, w.anchor(1)->x + 4);
      for (int i = 0; i < 4; ++i) ASSERT_NEAR(now[i], held[i], 1e-12) << "size " << size;
    }
    EXPECT_EQ(w.jointCovariance()(9, 9), 0);
    EXPECT_GT(w.jointCovariance()(5, 5), 0);
  }
}

TEST(MergeRanges, CountsMeansAndSigma) {
  std::vector<HeldRange> list(2);
  list[0].t = 100;
  list[0].range_m = 4;
  list[0].sigma_m = list[1].sigma_m = 0.1;
  list[0].motion = Vec3(1, 0, 0);
  list[0].lever = Vec3(0, 1, 0);
  list[1].t = 300;
  list[1].range_m = 5;
  list[1].motion = Vec3(2, 0, 0);
  list[1].lever = Vec3(0, 0, 1);
  mergeRanges(&list, 2);
  ASSERT_EQ(list.size(), 2u);
  mergeRanges(&list, 1);
  ASSERT_EQ(list.size(), 1u);
  EXPECT_EQ(list[0].merged, 2);
  EXPECT_EQ(list[0].t, 200);
  EXPECT_DOUBLE_EQ(list[0].range_m, 4.5);
  EXPECT_NEAR(list[0].sigma_m, 0.1 / std::sqrt(2), 1e-15);
  EXPECT_LT((list[0].motion - Vec3(1.5, 0, 0)).norm(), 1e-15);
  EXPECT_LT((list[0].lever - Vec3(0, 0.5, 0.5)).norm(), 1e-15);
  // Weighted by what each stands for: two at 4.5 and one at 6.
  HeldRange third;
  third.t = 500;
  third.range_m = 6;
  third.sigma_m = 0.1;
  list.push_back(third);
  mergeRanges(&list, 1);
  ASSERT_EQ(list.size(), 1u);
  EXPECT_EQ(list[0].merged, 3);
  EXPECT_DOUBLE_EQ(list[0].range_m, 5);
  EXPECT_NEAR(list[0].sigma_m, 0.1 / std::sqrt(3), 1e-15);
}

TEST(MergeRanges, DifferencesOfOnePairOnly) {
  std::vector<HeldRange> list(6);
  for (std::size_t k = 0; k < list.size(); ++k) {
    list[k].t = static_cast<TimeNs>(k);
    list[k].range_m = static_cast<double>(k);
    list[k].anchor = 1;
    if (k >= 2) list[k].reference = k < 4 ? 2 : 3;
  }
  mergeRanges(&list, 1);
  ASSERT_EQ(list.size(), 3u);
  EXPECT_FALSE(list[0].reference);
  EXPECT_DOUBLE_EQ(list[0].range_m, 0.5);
  EXPECT_EQ(list[1].reference, 2u);
  EXPECT_DOUBLE_EQ(list[1].range_m, 2.5);
  EXPECT_EQ(list[2].reference, 3u);
  EXPECT_DOUBLE_EQ(list[2].range_m, 4.5);
}

TEST(MergeRanges, NeverMoreThanTheLimitNorBetterThanAQuarter) {
  std::vector<HeldRange> list;
  double sum = 0;
  for (int k = 0; k < 1000; ++k) {
    HeldRange r;
    r.t = k;
    r.anchor = k % 5 == 0 ? 1 : 0;
    r.range_m = 5 + 0.01 * (k % 7);
    sum += r.range_m;
    list.push_back(r);
  }
  mergeRanges(&list, 16);  // a rush of ranges at once
  std::map<std::uint64_t, int> count, merged;
  double mean = 0;
  for (const HeldRange& r : list) {
    ++count[r.anchor];
    merged[r.anchor] += r.merged;
    mean += r.merged * r.range_m / 1000;
    EXPECT_GE(r.sigma_m, 0.1 / 4 - 1e-15);
  }
  EXPECT_LE(count[0], 16);
  EXPECT_LE(count[1], 16);
  EXPECT_EQ(merged[0], 800);
  EXPECT_EQ(merged[1], 200);
  EXPECT_NEAR(mean, sum / 1000, 1e-9);
  EXPECT_TRUE(std::is_sorted(list.begin(), list.end(), [](const HeldRange& a, const HeldRange& b) {
    return a.anchor == b.anchor && a.t < b.t;
  }));
}

}  // namespace
}  // namespace vir::window
