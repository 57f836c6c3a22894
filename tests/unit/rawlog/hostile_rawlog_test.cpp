/// A rawlog that somebody made to do harm: sizes that are not true, names that lead elsewhere,
/// poses that cannot be.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <cmath>
#include <cstring>

#include "vir/core/time_bounds.h"
#include "vir/rawlog/live_recording.h"
#include "vir/rawlog/rawlog_reader.h"
#include "vir/rawlog/time_orderer.h"
#include "vir_test_rawlog.h"
#include "vir_test_temp_folder.h"

namespace vir::rawlog {
namespace {

namespace fs = std::filesystem;
using test::imageAt;
using test::imuAt;
using test::kMs;
using test::kStart;
using test::TempFolder;

struct Outcome {
  std::vector<mrpt::obs::CObservation::Ptr> observations;
  std::string damage, refusals;
};

Outcome readAll(const fs::path& path) {
  RawlogReader reader(path.string());
  Outcome out;
  while (const auto o = reader.next()) out.observations.push_back(o);
  out.damage = reader.damage();
  out.refusals = reader.refusals();
  return out;
}

long peakKb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss;
}

/// A recording stored as it is, with the 4 bytes before `mark` + `back` set to `size`.
fs::path bomb(const TempFolder& folder, const std::string& mark, std::size_t back,
              std::uint32_t size) {
  const fs::path path = folder / "bomb.rawlog";
  fs::remove(path);
  LiveRecording writer(path.string(), {});  // without gzip's checksum
  for (int i = 0; i < 5; ++i) writer.write(*imuAt(kStart + i * kMs), true);
  writer.write(*test::rangeAt(kStart + 6 * kMs, 3), true);
  writer.close();
  std::string bytes = test::readText(path);
  const std::size_t at = bytes.rfind(mark) - back;
  EXPECT_LT(at, bytes.size());
  std::memcpy(bytes.data() + at, &size, sizeof size);
  test::writeText(path, bytes);
  return path;
}

void expectBounded(const fs::path& path, std::size_t before) {
  rlimit limit{}, after{};
  getrlimit(RLIMIT_AS, &limit);
  const long kb = peakKb();
  const Outcome out = readAll(path);
  getrlimit(RLIMIT_AS, &after);
  EXPECT_EQ(out.observations.size(), before);
  EXPECT_NE(out.damage.find("a size in it is larger than what the file can hold"),
            std::string::npos)
      << out.damage;
  EXPECT_LT(peakKb() - kb, 300'000);
  EXPECT_EQ(limit.rlim_cur, after.rlim_cur) << "the bound outlives the reader";
}

TEST(HostileRawlog, LengthOfALabel) {
  const TempFolder folder;
  expectBounded(bomb(folder, "UWB0", 4, 0xffffffff), 5);
  expectBounded(bomb(folder, "IMU0", 4, 0x7fffffff), 4);
}

TEST(HostileRawlog, NumberOfRanges) {
#ifdef VIR_SANITIZED
  GTEST_SKIP()
      << "small pieces of memory are of what the sanitizer has reserved, which no bound takes away";
#endif
  const TempFolder folder;
  expectBounded(bomb(folder, "mrpt::poses::CPoint3D", 5, 0xffffffff), 5);
  expectBounded(bomb(folder, "mrpt::poses::CPoint3D", 5, 0x04000000), 5);
}

/// 100 MB of nothing are 100 kB in the file.
TEST(HostileRawlog, UnpacksToManyTimesItsSize) {
  const TempFolder folder;
  const fs::path path = folder / "zeros.rawlog";
  auto imu = imuAt(kStart);
  imu->sensorLabel.assign(100'000'000, '\0');
  RawlogWriter writer(path.string(), 9);
  writer.write(*imuAt(kStart));
  writer.write(*imu);
  writer.finish();
  ASSERT_LT(fs::file_size(path), 200'000u);
  const Outcome out = readAll(path);
  EXPECT_EQ(out.observations.size(), 1u);
  EXPECT_NE(out.damage.find("unpacks to more than 200 times"), std::string::npos) << out.damage;
}

class NamesOfImages : public testing::Test {
 protected:
  NamesOfImages() {
    fs::create_directories(folder_ / "flight/a_Images/deeper");
    test::writeText(folder_ / "secret.png", "secret");
    test::writeText(folder_ / "flight/a_Images/good.png", "x");
  }
  Outcome named(const std::string& name) {
    const fs::path path = folder_ / "flight/a.rawlog";
    auto image = imageAt(kStart);
    image->image.setExternalStorage(name);
    RawlogWriter writer(path.string());
    writer.write(*image);
    writer.finish();
    return readAll(path);
  }
  static std::string fileOf(const Outcome& out) {
    const auto image =
        std::dynamic_pointer_cast<mrpt::obs::CObservationImage>(out.observations.at(0));
    return image->image.getExternalStorageFile();
  }
  void expectRefused(const std::string& name, const std::string& why) {
    const Outcome out = named(name);
    ASSERT_EQ(out.observations.size(), 1u);
    EXPECT_NE(out.refusals.find("1 images were refused"), std::string::npos) << out.refusals;
    EXPECT_NE(out.refusals.find(why), std::string::npos) << out.refusals;
    EXPECT_FALSE(fs::exists(fileOf(out))) << fileOf(out);
  }
  TempFolder folder_;
};

TEST_F(NamesOfImages, InTheFolderAreRead) {
  for (const char* name : {"good.png", "deeper/../good.png"}) {
    const Outcome out = named(name);
    EXPECT_EQ(out.refusals, "");
    EXPECT_EQ(fileOf(out), (folder_ / "flight/a_Images/good.png").string());
  }
  EXPECT_EQ(named("missing.png").refusals, "") << "who decodes it says so";
}

TEST_F(NamesOfImages, OutsideTheFolderAreRefused) {
  expectRefused("../../secret.png", "leads out of the recording's folder");
  expectRefused((folder_ / "secret.png").string(), "leads out of the recording's folder");
  expectRefused("deeper/../../../secret.png", "leads out of the recording's folder");
  allowImagesElsewhere(true);
  EXPECT_EQ(fileOf(named("../../secret.png")), (folder_ / "secret.png").string());
  allowImagesElsewhere(false);
}

TEST_F(NamesOfImages, WhatIsNoFileIsRefused) {
  ASSERT_EQ(mkfifo((folder_ / "flight/a_Images/pipe.png").c_str(), 0644), 0);
  expectRefused("pipe.png", "is no file");
  expectRefused("deeper", "is no file");
  fs::create_symlink("pipe.png", folder_ / "flight/a_Images/to_pipe.png");
  expectRefused("to_pipe.png", "a link to something that is no image");
  fs::create_symlink("/etc/passwd", folder_ / "flight/a_Images/to_text.png");
  expectRefused("to_text.png", "a link to something that is no image");
  fs::create_symlink(folder_ / "secret.png", folder_ / "flight/a_Images/to_image.png");
  EXPECT_EQ(named("to_image.png").refusals, "") << "import makes such links";
}

TEST(HostileRawlog, PosesThatCannotBeAreLeftOutAndCounted) {
  const TempFolder folder;
  const fs::path path = folder / "a.rawlog";
  RawlogWriter writer(path.string());
  auto far = imageAt(kStart);
  far->cameraPose = mrpt::poses::CPose3D(1e6, 0, 0, 0, 0, 0);
  auto nan = imageAt(kStart + kMs);
  nan->cameraPose = mrpt::poses::CPose3D(NAN, 0, 0, 0, 0, 0);
  auto lens = imageAt(kStart + 2 * kMs);
  lens->cameraParams.setIntrinsicParamsFromValues(NAN, 1, 1, 1);
  auto truth = test::truthAt(kStart, INFINITY);
  auto range = test::rangeAt(kStart, 1);
  range->sensedData[0].sensorLocationOnRobot.x(1e30);
  writer.write(*far);
  writer.write(*nan);
  writer.write(*lens);
  writer.write(*truth);
  writer.write(*range);
  writer.write(*imageAt(kStart + 3 * kMs));
  writer.finish();
  const Outcome out = readAll(path);
  EXPECT_EQ(out.observations.size(), 1u);
  for (const char* said : {"CAM0: the camera is more than 1 km off the robot", "CAM0: the camera's",
                           "GT: a position is no number", "UWB0: the antenna is more than 1 km"}) {
    EXPECT_NE(out.refusals.find(said), std::string::npos) << said << " in " << out.refusals;
  }
}

/// MRPT's "no stamp", its limits, and dates of another age: "a gap of -7623372036 s".
TEST(HostileRawlog, StampsThatNoClockShowsAreLeftOutAndCounted) {
  const TempFolder folder;
  const fs::path path = folder / "x.rawlog";
  RawlogWriter writer(path.string());
  constexpr std::int64_t kSecond = 10'000'000;  // of MRPT's clock
  for (const std::int64_t ticks : {std::int64_t(0), INT64_MAX, INT64_MIN, kUnixEpochTicks - 1,
                                   std::int64_t(2650467743990000000),  // of the year 9999
                                   kUnixEpochTicks + 4'102'444'800 * kSecond}) {
    auto imu = imuAt(0);
    imu->timestamp = mrpt::Clock::time_point(mrpt::Clock::duration(ticks));
    writer.write(*imu);
  }
  writer.write(*imuAt(0));  // of a clock that counts from its start
  writer.write(*imuAt(kStart));
  writer.write(*imuAt(kLatestStamp - 100));
  writer.finish();
  const Outcome out = readAll(path);
  EXPECT_EQ(out.observations.size(), 3u);
  EXPECT_NE(out.refusals.find("6 observations left out of IMU0: it has no stamp"),
            std::string::npos)
      << out.refusals;
}

/// Stamps at both ends of what a stamp can be: their difference does not fit.
TEST(HostileRawlog, StampsAtBothEnds) {
  TimeOrderer orderer;
  auto first = imuAt(0), last = imuAt(0);
  first->timestamp = mrpt::Clock::time_point(mrpt::Clock::duration(-(INT64_MAX / 2)));
  last->timestamp = mrpt::Clock::time_point(mrpt::Clock::duration(INT64_MAX / 2));
  orderer.push(first);
  orderer.push(last);
  orderer.flush();
  EXPECT_EQ(orderer.pop(), first);
  EXPECT_EQ(orderer.pop(), nullptr);
  EXPECT_EQ(orderer.counters().at("bad_stamp_IMU0"), 1);
}

}  // namespace
}  // namespace vir::rawlog
