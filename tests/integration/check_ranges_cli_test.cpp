/// `vir-slam check` holds ranges against the ground truth.
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "vir_test_data.h"
#include "vir_test_variant.h"

namespace {

using vir::test::check;
using vir::test::Checked;
using vir::test::quoted;
using vir::test::Row;
using vir::test::Variant;
using vir::test::virSlam;

TEST(CheckCli, HoldsRangesAgainstTheTruth) {
  VIR_REQUIRE_DATA(source, "rendered_V102_32s");
  const auto ranges = [&](double factor, double longer_m, long long later_ns) {
    auto v = std::make_unique<Variant>(source, 30);
    v->rewrite("uwb0", "#timestamp [ns],anchor_id,range [m]", [&](const Row& r) {
      return Variant::line(r.t + later_ns,
                           std::vector<double>{r.v[0], factor * (r.v[1] + longer_m)});
    });
    return v;
  };
  using Kinds = std::vector<std::string>;
  Checked c = check(*ranges(1 / 0.3048, 0, 0));
  EXPECT_EQ(c.code, 1) << c.text;
  EXPECT_EQ(c.kinds, Kinds{"ranges_in_ft"}) << c.text;
  EXPECT_TRUE(vir::test::contains(c.text, "csv.range_unit")) << c.text;
  // With what it says to do, it is right.
  const auto feet = ranges(1 / 0.3048, 0, 0);
  EXPECT_EQ(check(*feet, "--set euroc.range_unit=ft").code, 0);
  c = check(*ranges(1, 1.2, 0));
  EXPECT_EQ(c.code, 3) << c.text;
  EXPECT_EQ(c.kinds, Kinds{"range_bias"}) << c.text;
  c = check(*ranges(1, 0, 300'000'000));
  EXPECT_EQ(c.code, 3) << c.text;
  EXPECT_EQ(c.kinds, Kinds{"range_time_offset"}) << c.text;
  // So are a factor and a shift.
  const auto off = ranges(1.05, 0, 300'000'000);
  c = check(*off);
  EXPECT_EQ(c.code, 3) << c.text;
  EXPECT_EQ(c.kinds, (Kinds{"range_scale", "range_time_offset"})) << c.text;
  EXPECT_EQ(check(*off, "--set euroc.range_factor=0.952 --set euroc.range_time_offset_s=-0.3").code,
            0);
  // The rawlog knows the anchors by the file beside it.
  const Variant v(source, 30);
  const std::string rawlog = v.out("x.rawlog");
  ASSERT_EQ(virSlam("import " + v.folder() + " --out " + quoted(rawlog)).code, 0);
  vir::test::writeText(v.out("x_anchors_truth.csv"), "#id,x,y,z\n0,4.62,0.523,2.62\n");
  const auto o = virSlam("check " + quoted(rawlog));
  EXPECT_EQ(o.code, 3) << o.text;
  EXPECT_TRUE(vir::test::contains(o.text, "anchor 0 is not where the table of true anchors has it"))
      << o.text;
}

TEST(CheckCli, NamesTheRootAndNotWhatFollowsFromIt) {
  VIR_REQUIRE_DATA(source, "rendered_V102_32s");
  // Every image twice: its turning says nothing of lens or clock.
  const Variant twice(source, 15);
  std::string last;
  int i = 0;
  twice.rewrite("cam0", "#timestamp [ns],filename", [&](const Row& r) {
    if (i++ % 2 == 0) last = r.rest;
    return Variant::line(r.t, last);
  });
  const Checked copies = check(twice);
  EXPECT_EQ(copies.code, 3) << copies.text;
  EXPECT_EQ(copies.kinds, std::vector<std::string>{"frozen"}) << copies.text;
  // The IMU's axes as in NED.
  const Variant ned(source, 15);
  ned.imu([](std::vector<double>* v) {
    for (const std::size_t k : {1u, 2u, 4u, 5u}) (*v)[k] = -(*v)[k];
  });
  const Checked turned = check(ned);
  EXPECT_EQ(turned.code, 1) << turned.text;
  EXPECT_EQ(turned.kinds.size(), 1u) << turned.text;
  EXPECT_TRUE(vir::test::contains(turned.text, "x is x, y is -y, z is -z (z down, as in NED"))
      << turned.text;
}

}  // namespace
