#include "vir/check/stream_check.h"

#include <gtest/gtest.h>

#include "found.h"

namespace vir::check {
namespace {

constexpr TimeNs kDate = 1400000000000000000;

StreamSummary stream(const char* label, StreamKind kind, TimeNs first, TimeNs step, int count) {
  StreamCheck s(label, kind);
  for (int i = 0; i < count; ++i) s.add(first + i * step);
  return s.summary();
}

StreamSummary imu(TimeNs first = kDate, TimeNs step = 5000000, int count = 2000) {
  return stream("IMU0", StreamKind::imu, first, step, count);
}
StreamSummary images(TimeNs first = kDate, TimeNs step = 50000000, int count = 200) {
  return stream("CAM0", StreamKind::images, first, step, count);
}

TEST(StreamCheck, CountsRatesAndGaps) {
  StreamCheck s("CAM0", StreamKind::images);
  for (const TimeNs t : {0, 50, 100, 150, 140, 150, 400}) s.add(kDate + t * 1000000);
  const StreamSummary sum = s.summary();
  EXPECT_EQ(sum.count, 7);
  EXPECT_DOUBLE_EQ(sum.rate_hz, 20);
  EXPECT_DOUBLE_EQ(sum.longest_gap_s, 0.25);
  EXPECT_EQ(sum.out_of_order, 1);
  EXPECT_EQ(sum.repeated, 1);
}

TEST(StreamCheck, NothingIsWrongWithARecording) {
  EXPECT_TRUE(checkStreams({images(), imu(), stream("GT", StreamKind::poses, kDate, 5000000, 50),
                            stream("UWB0", StreamKind::ranges, kDate, 2000000000, 5)})
                  .empty());
}

TEST(StreamCheck, NamesTheUnitOfStamps) {
  EXPECT_EQ(seriousKinds(checkStreams({images(1400000000000, 50), imu(1400000000000, 5)})),
            (Kinds{"stamps_in_ms", "stamps_in_ms"}));
  EXPECT_EQ(seriousKinds(checkStreams({images(1400000000000000, 50000)})),
            (Kinds{"stamps_in_us", "no_imu"}));
  EXPECT_EQ(seriousKinds(checkStreams({imu(7, 200)})), Kinds{"rate"});
}

TEST(StreamCheck, NamesBurstsAndJitter) {
  StreamCheck bursts("IMU0", StreamKind::imu);
  for (int i = 0; i < 2000; ++i) bursts.add(kDate + (i / 10) * 50000000LL + (i % 10) * 1000LL);
  EXPECT_EQ(seriousKinds(checkStreams({images(), bursts.summary()})), Kinds{"bursts"});
  StreamCheck jitter("CAM0", StreamKind::images);
  for (int i = 0; i < 200; ++i)
    jitter.add(kDate + i * 50000000LL + (i * i * 37 % 11 - 5) * 4000000LL);
  EXPECT_EQ(seriousKinds(checkStreams({jitter.summary(), imu()})), Kinds{"jitter"});
  StreamCheck exposure("CAM0", StreamKind::images);
  for (int i = 0; i < 200; ++i)
    exposure.add(kDate + i * 50000000LL + (i * i * 37 % 11 - 5) * 400000LL);
  EXPECT_TRUE(checkStreams({exposure.summary(), imu()}).empty());
}

TEST(StreamCheck, NamesARateThatChanges) {
  StreamCheck half("IMU0", StreamKind::imu);
  TimeNs t = kDate;
  for (int i = 0; i < 3000; ++i) half.add(t += i < 2000 ? 5000000 : 10000000);
  const auto findings = checkStreams({images(), half.summary()});
  ASSERT_EQ(seriousKinds(findings), Kinds{"rate_changes"});
  EXPECT_NE(findings[0].what.find("from 200 to 100 Hz, 10.01 s after"), std::string::npos)
      << findings[0].what;
  // A camera may go with the light, and one hole or slow second is no other rate.
  StreamCheck camera("CAM0", StreamKind::images), hole("IMU0", StreamKind::imu);
  t = kDate;
  for (int i = 0; i < 300; ++i) camera.add(t += i < 200 ? 50000000 : 100000000);
  StreamCheck all_along("IMU0", StreamKind::imu);
  for (int i = 0; i < 4100; ++i) all_along.add(kDate + i * 5000000LL);
  EXPECT_EQ(seriousKinds(checkStreams({camera.summary(), all_along.summary()})), Kinds{});
  t = kDate;
  for (int i = 0; i < 3000; ++i) hole.add(t += i > 1000 && i < 1030 ? 9000000 : 5000000);
  EXPECT_EQ(seriousKinds(checkStreams({images(), hole.summary()})), Kinds{});
}

TEST(StreamCheck, NamesClocksThatDoNotMeet) {
  const auto findings = checkStreams({images(), imu(43847434001234)});
  ASSERT_EQ(seriousKinds(findings), Kinds{"no_overlap"});
  EXPECT_EQ(findings[0].severity, Severity::unusable);
  EXPECT_NE(findings[0].what.find("IMU0 counts from power-up, CAM0 is Unix time"),
            std::string::npos)
      << findings[0].what;
  EXPECT_NE(findings[0].evidence.find("43847.434"), std::string::npos) << findings[0].evidence;
  EXPECT_NE(findings[0].evidence.find("1400000000.000"), std::string::npos);
  EXPECT_NE(findings[0].remedy.find(".imu_time_offset_s=1399956152.57"), std::string::npos)
      << findings[0].remedy;
  // Not where another camera has the IMU's clock.
  const auto second = stream("CAM1", StreamKind::images, 43847434001234, 50000000, 200);
  const auto two = checkStreams({images(), second, imu(43847434001234)});
  ASSERT_EQ(seriousKinds(two), Kinds{"no_overlap"});
  EXPECT_EQ(two[0].remedy, "put both on one clock before importing");
  EXPECT_EQ(seriousKinds(checkStreams({images(kDate + 9000000000), imu()})),
            Kinds{"little_overlap"});
}

/// What is wrong with one camera hides nothing of another.
TEST(StreamCheck, ASecondCameraIsJudgedByItself) {
  const StreamSummary in_ms = stream("CAM1", StreamKind::images, kDate / 1000000, 50, 200);
  const StreamSummary elsewhere = images(kDate + 3600 * 1000000000LL);
  EXPECT_EQ(seriousKinds(checkStreams({elsewhere, in_ms, imu()})),
            (Kinds{"stamps_in_ms", "no_overlap"}));
  StreamCheck hole("CAM1", StreamKind::images);
  for (int i = 0; i < 200; ++i) {
    if (i < 50 || i > 90) hole.add(kDate + i * 50000000LL);
  }
  const auto findings = checkStreams({images(), hole.summary(), imu()});
  ASSERT_EQ(seriousKinds(findings), Kinds{"gap"});
  EXPECT_EQ(findings[0].remedy, "what lies in it is lost; a run has the other cameras meanwhile");
}

TEST(StreamCheck, NamesReadingsThatEndBeforeTheImagesAndThoseThatAreTooFew) {
  StreamCheck early("IMU0", StreamKind::imu), slow("IMU0", StreamKind::imu);
  for (int i = 0; i < 500; ++i) early.add(kDate + i * 5000000LL);
  EXPECT_EQ(seriousKinds(checkStreams({images(), early.summary()})), Kinds{"little_overlap"});
  for (int i = 0; i < 120; ++i) slow.add(kDate + i * 100000000LL);
  EXPECT_EQ(seriousKinds(checkStreams({images(), slow.summary()})), Kinds{"slow_imu"});
}

TEST(StreamCheck, NamesGapsAndDisorder) {
  StreamCheck s("IMU0", StreamKind::imu);
  for (int i = 0; i < 1000; ++i) s.add(kDate + i * 5000000LL + (i > 500 ? 300000000 : 0));
  EXPECT_EQ(seriousKinds(checkStreams({s.summary()})), Kinds{"gap"});
  StreamCheck back("IMU0", StreamKind::imu);
  for (int i = 0; i < 1000; ++i) back.add(kDate + (i % 10 == 9 ? i - 3 : i) * 5000000LL);
  EXPECT_EQ(seriousKinds(checkStreams({back.summary()})), Kinds{"order"});
}

}  // namespace
}  // namespace vir::check
