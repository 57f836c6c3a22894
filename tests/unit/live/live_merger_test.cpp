/// Time order of live sensors.
#include "vir/live/live_merger.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "vir_test_rawlog.h"

namespace vir::live {
namespace {

using test::imuAt;
using test::kMs;
using test::rangeAt;

struct Out {
  std::vector<long> in_order, aside;  // [ms]
};

void drain(LiveMerger* merger, TimeNs now, Out* out) {
  while (const auto item = merger->pop(now)) {
    const long t = static_cast<long>(rawlog::fromMrptTime(item->observation->timestamp) / kMs);
    (item->in_order ? out->in_order : out->aside).push_back(t);
  }
}

LiveMergerOptions options(long delay_ms) {
  LiveMergerOptions o;
  o.delay = delay_ms * kMs;
  return o;
}

TEST(LiveMerger, WaitsForTheOtherSensorAndNoLongerThanTheDelay) {
  LiveMerger merger(2, options(100));
  Out out;
  merger.push(0, imuAt(10 * kMs), 1000 * kMs);
  merger.push(0, imuAt(20 * kMs), 1001 * kMs);
  merger.push(1, rangeAt(15 * kMs, 1), 1002 * kMs);
  drain(&merger, 1003 * kMs, &out);
  // Nothing older than 15 can come any more; 20 has to wait for sensor 1.
  EXPECT_EQ(out.in_order, (std::vector<long>{10, 15}));
  drain(&merger, 1100 * kMs, &out);
  EXPECT_EQ(out.in_order.size(), 2u);
  drain(&merger, 1101 * kMs, &out);
  EXPECT_EQ(out.in_order, (std::vector<long>{10, 15, 20}));
}

TEST(LiveMerger, ASensorThatBeginsLaterIsWaitedForOnce) {
  LiveMerger merger(2, options(100));
  Out out;
  merger.push(0, imuAt(20 * kMs), 1000 * kMs);
  drain(&merger, 1050 * kMs, &out);
  EXPECT_TRUE(out.in_order.empty());
  merger.push(1, rangeAt(10 * kMs, 1), 1060 * kMs);
  merger.push(1, rangeAt(30 * kMs, 1), 1061 * kMs);
  drain(&merger, 1061 * kMs, &out);
  EXPECT_EQ(out.in_order, (std::vector<long>{10, 20}));
  EXPECT_TRUE(out.aside.empty());
}

TEST(LiveMerger, WhatIsTooLateComesOutMarked) {
  LiveMerger merger(2, options(50));
  Out out;
  merger.push(0, imuAt(100 * kMs), 1000 * kMs);
  drain(&merger, 1060 * kMs, &out);
  merger.push(1, rangeAt(90 * kMs, 1), 1061 * kMs);
  merger.push(1, rangeAt(110 * kMs, 1), 1062 * kMs);
  merger.flush();
  drain(&merger, 1062 * kMs, &out);
  EXPECT_EQ(out.in_order, (std::vector<long>{100, 110}));
  EXPECT_EQ(out.aside, (std::vector<long>{90}));
}

TEST(LiveMerger, AStampFarAheadDoesNotMakeTheOthersLate) {
  LiveMerger merger(2, options(50));
  Out out;
  for (long k = 0; k < 20; ++k) {
    merger.push(0, imuAt(10 * k * kMs), (1000 + 10 * k) * kMs);
    // Its clock is an hour ahead.
    if (k % 5 == 0) merger.push(1, rangeAt(3600000 * kMs + 10 * k * kMs, 1), (1000 + 10 * k) * kMs);
    drain(&merger, (1000 + 10 * k) * kMs, &out);
  }
  merger.flush();
  drain(&merger, 2000 * kMs, &out);
  EXPECT_EQ(out.in_order.size(), 20u);
  EXPECT_EQ(out.aside.size(), 4u);
}

/// A radio that falls silent, an image a second: what the others say is still in order.
TEST(LiveMerger, ASilentSensorDoesNotMakeTheOthersSeemAhead) {
  LiveMerger merger(2, options(100));
  Out out;
  merger.push(1, rangeAt(0, 1), 5000 * kMs);
  for (long k = 0; k < 600; ++k) {
    merger.push(0, imuAt(10 * k * kMs), (5000 + 10 * k) * kMs);
    drain(&merger, (5000 + 10 * k) * kMs, &out);
  }
  merger.push(1, rangeAt(5990 * kMs, 1), 11000 * kMs);
  merger.flush();
  drain(&merger, 11000 * kMs, &out);
  EXPECT_EQ(out.in_order.size(), 602u);
  EXPECT_TRUE(out.aside.empty());
}

TEST(LiveMerger, NobodyWaitsForASensorThatHasEnded) {
  LiveMerger merger(2, options(100000));
  Out out;
  merger.push(1, rangeAt(5 * kMs, 1), 1000 * kMs);
  merger.push(0, imuAt(10 * kMs), 1000 * kMs);
  drain(&merger, 1001 * kMs, &out);
  EXPECT_EQ(out.in_order, (std::vector<long>{5}));
  merger.setEnded(1);
  drain(&merger, 1001 * kMs, &out);
  EXPECT_EQ(out.in_order, (std::vector<long>{5, 10}));
}

}  // namespace
}  // namespace vir::live
