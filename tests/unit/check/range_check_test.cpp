#include "vir/check/range_check.h"

#include <gtest/gtest.h>

#include <cmath>

#include "found.h"
#include "vir/core/random.h"

namespace vir::check {
namespace {

Kinds kindsOf(double scale, bool whole) {
  RangeCheck check("UWB0");
  Random random(1);
  for (int i = 0; i < 600; ++i) {
    Range r;
    r.t = i * 50000000LL;
    r.anchor = 3;
    r.sigma_m = 0.05;
    const double m = 4 + 2 * std::sin(0.02 * i) + 0.05 * random.normal();
    r.range_m = whole ? std::round(scale * m) : scale * m;
    check.add(r);
  }
  return seriousKinds(check.findings());
}

TEST(RangeCheck, NamesTheUnit) {
  EXPECT_EQ(kindsOf(1, false), Kinds{});
  EXPECT_EQ(kindsOf(1000, true), Kinds{"ranges_in_mm"});
  EXPECT_EQ(kindsOf(100, true), Kinds{"ranges_in_cm"});
  EXPECT_EQ(kindsOf(1000, false), Kinds{"ranges_in_mm"});
}

/// Four antennas under one id, as a file without their column has them.
TEST(RangeCheck, NamesRangesThatAreFarNoisierThanGiven) {
  RangeCheck check("UWB0");
  for (int i = 0; i < 600; ++i) {
    const double antenna = 1.5 * std::sin(2.0 * i);
    check.add(Range{i * 50000000LL, 1, 4 + 2 * std::sin(0.02 * i) + antenna, 0.05, Vec3::Zero()});
  }
  EXPECT_EQ(seriousKinds(check.findings()), Kinds{"range_noise"});
}

TEST(RangeCheck, NamesRangesThatAreNone) {
  RangeCheck check("UWB0");
  for (int i = 0; i < 100; ++i) check.add(Range{i * 1000000LL, 1, 0, 0.1, Vec3::Zero()});
  EXPECT_EQ(seriousKinds(check.findings()), Kinds{"ranges_not_positive"});
}

TEST(RangeCheck, AnyNumberOfAnchorsTakesNoMemory) {
  RangeCheck check("UWB0");
  for (int i = 0; i < 100000; ++i) {
    check.add(Range{i * 1000000LL, static_cast<std::uint64_t>(i), 3, 0.1, Vec3::Zero()});
  }
  EXPECT_EQ(seriousKinds(check.findings()), Kinds{});
}

}  // namespace
}  // namespace vir::check
