/// Ranges that are none of the robot's own go by their label, there and back.
#include <gtest/gtest.h>

#include <stdexcept>

#include "vir/rawlog/anchor_ranges.h"
#include "vir/rawlog/convert.h"
#include "vir/rawlog/labels.h"
#include "vir/rawlog/range_differences.h"

namespace vir::rawlog {
namespace {

constexpr TimeNs kT = 1'700'000'000'000'000'000;

TEST(LabelledRanges, ADifferenceComesBackAndIsNoRange) {
  Range difference;
  difference.t = kT;
  difference.anchor = 4;
  difference.reference = 7;
  difference.range_m = -1.25;
  difference.sigma_m = 0.125;
  const auto o = differenceObservation(difference);
  EXPECT_EQ(o->sensorLabel, differencesName() + ":7");
  EXPECT_TRUE(rangesOf(*o).empty());
  const auto back = rangeDifferencesOf(*o);
  ASSERT_EQ(back.size(), 1u);
  EXPECT_EQ(back[0].reference, std::uint64_t{7});
  EXPECT_EQ(back[0].anchor, 4u);
  EXPECT_EQ(back[0].t, kT);
  EXPECT_EQ(back[0].range_m, -1.25);
  EXPECT_EQ(back[0].sigma_m, 0.125);
}

TEST(LabelledRanges, ADifferenceNeedsAReference) {
  EXPECT_THROW(differenceObservation(Range{}), std::invalid_argument);
  for (const char* label : {"TDOA", "TDOA:", "TDOA:x", "TDOA:1x", "UWB0", ""}) {
    const auto o = toObservation(Range{}, label, kUnknownRadio);
    EXPECT_TRUE(rangeDifferencesOf(*o).empty()) << label;
  }
}

TEST(LabelledRanges, ARangeBetweenAnchorsComesBack) {
  AnchorRange range;
  range.t = kT;
  range.first = 3;
  range.second = 9;
  range.range_m = 5.5;
  range.sigma_m = 0.25;
  const auto o = toObservation(range);
  const auto back = anchorRangesOf(*o);
  ASSERT_EQ(back.size(), 1u);
  EXPECT_EQ(back[0].first, 3u);
  EXPECT_EQ(back[0].second, 9u);
  EXPECT_EQ(back[0].t, kT);
  EXPECT_EQ(back[0].range_m, 5.5);
  EXPECT_EQ(back[0].sigma_m, 0.25);
  o->sensorLabel = "ANCHOR:-3";
  EXPECT_TRUE(anchorRangesOf(*o).empty());
}

}  // namespace
}  // namespace vir::rawlog
