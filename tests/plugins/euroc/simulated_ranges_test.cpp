#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "input_error.h"
#include "range_simulator.h"
#include "recording.h"
#include "vir_test_euroc_folder.h"

namespace vir::euroc {
namespace {

EurocOptions drawOptions() {
  EurocOptions o;
  o.simulate_ranges = true;
  o.anchor_m = {3, -1, 2.5};
  o.range_sigma_m = 0;
  return o;
}

test::EurocFolder longFolder() {
  test::EurocFolderOptions fo;
  fo.images = 100;
  return test::EurocFolder(fo);
}

std::vector<SimulatedRange> draw(const test::EurocFolder& f, const EurocOptions& o,
                                 ProblemLog* log) {
  RangeSimulator sim(
      o, openGroundTruth((f.mav0() / "state_groundtruth_estimate0/data.csv").string(), log), Pose(),
      log);
  std::vector<SimulatedRange> out;
  for (; sim.peek(); sim.pop()) out.push_back(*sim.peek());
  return out;
}

/// Exact range at a stamp: the ground truth moves on a line and turns about z.
double exact(const test::EurocFolder& f, TimeNs t, const Vec3& lever, const Vec3& anchor) {
  const double s = toSeconds(t - f.o.start_ns);
  const Vec3 p(test::truthX(s), 0.5, 1.5);
  return (p + rotZ(test::truthYaw(s)) * lever - anchor).norm();
}

TEST(RangeSimulator, WithoutNoiseGivesTheRangeAtItsOwnTime) {
  const auto f = longFolder();
  EurocOptions o = drawOptions();
  o.lever_arm_m = {0.3, 0.4, -0.2};
  ProblemLog log;
  const auto ranges = draw(f, o, &log);
  ASSERT_GE(ranges.size(), 97u);  // 4.95 s at 20 Hz
  ASSERT_LE(ranges.size(), 99u);
  int on_a_pose = 0;
  for (const auto& r : ranges) {
    EXPECT_NEAR(r.range_m, exact(f, r.t, Vec3(0.3, 0.4, -0.2), Vec3(3, -1, 2.5)), 2e-6);
    on_a_pose += (r.t - f.o.start_ns) % f.o.imu_period_ns == 0;
  }
  EXPECT_LT(on_a_pose, 3);  // own, jittered times
  EXPECT_TRUE(std::is_sorted(ranges.begin(), ranges.end(),
                             [](const auto& a, const auto& b) { return a.t < b.t; }));
}

TEST(RangeSimulator, NoiseHasTheSigmaAskedFor) {
  test::EurocFolderOptions fo;
  fo.images = 1000;
  fo.width = fo.height = 8;
  const test::EurocFolder f(fo);
  EurocOptions o = drawOptions();
  o.range_sigma_m = 0.1;
  o.range_rate_hz = 100;
  ProblemLog log;
  const auto ranges = draw(f, o, &log);
  ASSERT_GT(ranges.size(), 4900u);
  double sum = 0, sum2 = 0;
  for (const auto& r : ranges) {
    const double e = r.range_m - exact(f, r.t, Vec3::Zero(), Vec3(3, -1, 2.5));
    sum += e;
    sum2 += e * e;
  }
  const double n = static_cast<double>(ranges.size());
  EXPECT_NEAR(sum / n, 0.0, 0.1 * 4 / std::sqrt(n));
  EXPECT_NEAR(std::sqrt(sum2 / n), 0.1, 0.1 * 4 / std::sqrt(2 * n));
}

TEST(RangeSimulator, NoLineOfSightOnlyLengthens) {
  const auto f = longFolder();
  EurocOptions o = drawOptions();
  o.range_rate_hz = 200;
  o.nlos_share = 0.3;
  o.nlos_min_m = 0.5;
  o.nlos_max_m = 1.5;
  ProblemLog log;
  const auto ranges = draw(f, o, &log);
  long blocked = 0;
  for (const auto& r : ranges) {
    const double e = r.range_m - exact(f, r.t, Vec3::Zero(), Vec3(3, -1, 2.5));
    if (r.line_of_sight) {
      EXPECT_NEAR(e, 0, 2e-6);
    } else {
      ++blocked;
      EXPECT_GE(e, 0.5 - 2e-6);
      EXPECT_LE(e, 1.5 + 2e-6);
    }
  }
  const double n = static_cast<double>(ranges.size());
  EXPECT_NEAR(static_cast<double>(blocked) / n, 0.3, 4 * std::sqrt(0.21 / n));
}

TEST(RangeSimulator, OneSeedOneResult) {
  const auto f = longFolder();
  EurocOptions o = drawOptions();
  o.range_sigma_m = 0.1;
  ProblemLog log;
  const auto a = draw(f, o, &log), b = draw(f, o, &log);
  o.range_seed = 2;
  const auto c = draw(f, o, &log);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].t, b[i].t);
    EXPECT_EQ(a[i].range_m, b[i].range_m);
  }
  EXPECT_NE(a[0].range_m, c[0].range_m);
}

TEST(RangeSimulator, SeveralAnchorsInTurn) {
  const auto f = longFolder();
  EurocOptions o = drawOptions();
  o.anchor_m = {3, -1, 2.5, 0, 5, 1};
  o.anchor_id = {7, 9};
  ProblemLog log;
  const auto ranges = draw(f, o, &log);
  const auto seven =
      std::count_if(ranges.begin(), ranges.end(), [](const auto& r) { return r.anchor == 7; });
  EXPECT_NEAR(static_cast<double>(seven), 98, 1);
  EXPECT_NEAR(static_cast<double>(ranges.size()), 196, 2);
  for (const auto& r : ranges) {
    const Vec3 anchor = r.anchor == 7 ? Vec3(3, -1, 2.5) : Vec3(0, 5, 1);
    EXPECT_NEAR(r.range_m, exact(f, r.t, Vec3::Zero(), anchor), 2e-6);
  }
}

TEST(RangeSimulator, NoRangeInAHoleOfTheGroundTruth) {
  const auto f = longFolder();
  // Leaves the first 2 s and the last: 2 s are missing in between.
  std::istringstream in(f.read("state_groundtruth_estimate0/data.csv"));
  std::string line, kept;
  for (int i = 0; std::getline(in, line); ++i) {
    if (i <= 400 || i > 800) kept += line + "\n";
  }
  f.write("state_groundtruth_estimate0/data.csv", kept);
  ProblemLog log;
  const auto ranges = draw(f, drawOptions(), &log);
  for (const auto& r : ranges) {
    const double s = toSeconds(r.t - f.o.start_ns);
    EXPECT_TRUE(s < 2.0 || s > 3.99) << s;
  }
  EXPECT_NEAR(static_cast<double>(log.get("range_in_ground_truth_gap")), 40, 2);
}

TEST(RangeSimulator, TheRecordingDrawsInsteadOfReading) {
  const test::EurocFolder f;
  EurocOptions o = drawOptions();
  o.source = f.root().string();
  o.anchor_id = {5};
  ProblemLog log;
  Recording r(o, &log);
  Event e;
  TimeNs last = 0;
  int ranges = 0;
  while (r.next(&e)) {
    EXPECT_GE(e.t, last);
    last = e.t;
    if (const auto* range = std::get_if<RangeRow>(&e.what)) {
      ++ranges;
      EXPECT_EQ(range->anchor, 5);
    }
  }
  EXPECT_GE(ranges, 8);
}

TEST(RangeSimulator, SettingsThatCannotBe) {
  EurocOptions o = drawOptions();
  o.source = "x";
  EXPECT_NO_THROW(validate(o));
  o.anchor_m = {1, 2};
  EXPECT_THROW(validate(o), InputError);
  o.anchor_m = {};
  EXPECT_THROW(validate(o), InputError);
  o.anchor_m = {1, 2, 3, 4, 5, 6};
  o.anchor_id = {1};
  EXPECT_THROW(validate(o), InputError);
  o.anchor_id = {1, 1};
  EXPECT_THROW(validate(o), InputError);
  o.anchor_id = {1, 2.5};
  EXPECT_THROW(validate(o), InputError);
  o.anchor_id = {};
  o.nlos_min_m = 3;
  EXPECT_THROW(validate(o), InputError);
}

TEST(Random, FirstNumbersAreFixed) {
  // mt19937_64 is fixed by the standard; what is built on it must not change either, or drawn
  // ranges would differ between versions.
  Random r(5489);
  EXPECT_DOUBLE_EQ(r.uniform(), static_cast<double>(14514284786278117030ull >> 11) * 0x1.0p-53);
}

}  // namespace
}  // namespace vir::euroc
