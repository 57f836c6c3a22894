/// A rawlog that is sound at any moment.
#include "vir/rawlog/live_recording.h"

#include <gtest/gtest.h>
#include <mrpt/obs/CObservationImage.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <functional>
#include <string>
#include <vector>

#include "vir/live/live_recorder.h"
#include "vir/rawlog/rawlog_reader.h"
#include "vir_test_rawlog.h"
#include "vir_test_temp_folder.h"

namespace vir::rawlog {
namespace {

namespace fs = std::filesystem;
using test::imageAt;
using test::imuAt;
using test::kMs;
using test::kStart;

struct Content {
  std::vector<TimeNs> stamps;
  std::vector<int> pixels;  // first one of every image
  std::string damage;
};

Content contentOf(const std::string& path) {
  Content out;
  RawlogReader reader(path);
  while (const auto o = reader.next()) {
    out.stamps.push_back(fromMrptTime(o->timestamp));
    if (const auto image = std::dynamic_pointer_cast<mrpt::obs::CObservationImage>(o)) {
      out.pixels.push_back(*image->image.ptr<std::uint8_t>(0, 0));
    }
  }
  out.damage = reader.damage();
  return out;
}

TEST(LiveRecording, WhatIsFlushedIsReadableWhileTheFileIsOpen) {
  for (const int compression : {0, 1}) {
    const test::TempFolder folder;
    const std::string path = (folder / "a.rawlog").string();
    LiveRecordingOptions options;
    options.compression = compression;
    LiveRecording recording(path, options);
    for (int i = 0; i < 100; ++i) {
      recording.write(*imuAt(kStart + 5 * i * kMs), true);
      if (i == 49) recording.flush();
    }
    const Content half = contentOf(path);
    EXPECT_EQ(half.stamps.size(), 50u) << compression;
    EXPECT_EQ(half.damage, "");
    recording.close();
    const Content whole = contentOf(path);
    EXPECT_EQ(whole.stamps.size(), 100u);
    EXPECT_EQ(whole.stamps.back(), kStart + 495 * kMs);
    EXPECT_EQ(whole.damage, "");
  }
}

TEST(LiveRecording, ImagesGoWhereTheyWereAskedToGo) {
  for (const std::string images : {"png", "embed"}) {
    const test::TempFolder folder;
    const std::string path = (folder / "a.rawlog").string();
    LiveRecordingOptions options;
    options.images = images;
    LiveRecording recording(path, options);
    for (int i = 0; i < 5; ++i) {
      const auto image = imageAt(kStart + i * kMs, 10 + i);
      recording.write(*image, true);
      EXPECT_FALSE(image->image.isExternallyStored());  // the observation is left alone
    }
    recording.close();
    EXPECT_EQ(contentOf(path).pixels, (std::vector<int>{10, 11, 12, 13, 14})) << images;
    EXPECT_EQ(fs::exists(folder / "a_Images"), images == "png");
  }
}

TEST(LiveRecording, SplitsByTimeAndKeepsLateOnesAside) {
  const test::TempFolder folder;
  const std::string path = (folder / "a.rawlog").string();
  LiveRecordingOptions options;
  options.split_s = 0.1;
  LiveRecording recording(path, options);
  for (int i = 0; i < 50; ++i) recording.write(*imuAt(kStart + 5 * i * kMs), true);
  recording.write(*imuAt(kStart), false);
  recording.close();
  ASSERT_EQ(recording.parts().size(), 3u);
  EXPECT_EQ(recording.parts()[1], (folder / "a_part2.rawlog").string());
  std::size_t sum = 0;
  TimeNs last = 0;
  for (const std::string& part : recording.parts()) {
    for (const TimeNs t : contentOf(part).stamps) {
      EXPECT_GT(t, last);
      last = t;
      ++sum;
    }
  }
  EXPECT_EQ(sum, 50u);
  EXPECT_EQ(contentOf(recording.asidePath()).stamps, (std::vector<TimeNs>{kStart}));
}

TEST(LiveRecording, NothingIsOverwritten) {
  const test::TempFolder folder;
  const std::string path = (folder / "a.rawlog").string();
  test::writeText(folder / "a.rawlog", "mine");
  EXPECT_THROW(LiveRecording(path, {}), std::runtime_error);
  EXPECT_EQ(test::readText(folder / "a.rawlog"), "mine");
  // Nor a part of an earlier recording, whatever its number.
  test::writeText(folder / "b_part3.rawlog", "mine");
  EXPECT_THROW(LiveRecording((folder / "b.rawlog").string(), {}), std::runtime_error);
  EXPECT_THROW(LiveRecording((folder / "a.txt").string(), {}), std::runtime_error);
  EXPECT_THROW(LiveRecording("/proc/no/a.rawlog", {}), std::runtime_error);
}

/// In a process of its own, whose files may not grow beyond `limit` bytes: as a full disk.
int withFileLimit(rlim_t limit, const std::function<int()>& work) {
  const pid_t child = fork();
  if (child == 0) {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit size{limit, limit};
    setrlimit(RLIMIT_FSIZE, &size);
    try {
      _exit(work());
    } catch (...) {
      _exit(9);
    }
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST(LiveRecording, AFullDiskIsToldAndLeavesASoundFile) {
  for (const int compression : {0, 1}) {
    const test::TempFolder folder;
    const std::string path = (folder / "a.rawlog").string();
    SCOPED_TRACE(compression);
    const int code = withFileLimit(50000, [&] {
      LiveRecordingOptions options;
      options.compression = compression;
      LiveRecording recording(path, options);
      try {
        for (int i = 0; i < 20000; ++i) {
          const auto imu = imuAt(kStart + 5 * i * kMs);
          imu->set(mrpt::obs::IMU_WX, std::sin(i * i));
          recording.write(*imu, true);
          if (i % 20 == 19) recording.flush();
        }
      } catch (const std::runtime_error& e) {
        const bool named = std::string(e.what()).find("a.rawlog") != std::string::npos;
        try {
          recording.write(*imuAt(kStart), true);
          return 4;
        } catch (const std::runtime_error&) {
          return named ? 3 : 2;
        }
      }
      return 1;
    });
    EXPECT_EQ(code, 3);
    const Content content = contentOf(path);
    EXPECT_EQ(content.damage, "") << compression;
    EXPECT_GT(content.stamps.size(), 40u);
    EXPECT_EQ(content.stamps.size() % 20, 0u);
  }
}

/// It would stand in the way: a recording is never written over.
TEST(LiveRecording, OnADiskWithoutRoomForAByteThereIsNoFile) {
  const test::TempFolder folder;
  const std::string path = (folder / "a.rawlog").string();
  const int code = withFileLimit(0, [&] {
    LiveRecording recording(path, {});
    try {
      recording.write(*imuAt(kStart), true);
      recording.close();
    } catch (const std::runtime_error&) {
      return 3;
    }
    return 1;
  });
  EXPECT_EQ(code, 3);
  EXPECT_FALSE(fs::exists(path));
}

TEST(LiveRecorder, CountsWhatCannotBeWrittenAndGoesOnTakingIt) {
  const test::TempFolder folder;
  const std::string path = (folder / "a.rawlog").string();
  const int code = withFileLimit(50000, [&] {
    LiveRecordingOptions options;
    options.flush_s = 0.01;
    live::LiveRecorder recorder(path, options, {}, 1);
    for (int i = 0; i < 3000; ++i) {
      recorder.add({{0, imuAt(kStart + 5 * i * kMs), hostNow()}});
      if (i % 100 == 0) usleep(20000);
    }
    try {
      recorder.close();
      return 1;
    } catch (const std::runtime_error&) {
    }
    const live::LiveRecorder::Counts counts = recorder.counts();
    if (counts.lost == 0 || counts.written + counts.lost != 3000) return 2;
    // What was taken and then cut off again is lost too.
    return contentOf(path).stamps.size() == counts.written ? 3 : 4;
  });
  EXPECT_EQ(code, 3);
  EXPECT_EQ(contentOf(path).damage, "");
}

TEST(LiveRecorder, WritesEverythingInOrder) {
  const test::TempFolder folder;
  const std::string path = (folder / "a.rawlog").string();
  live::LiveMergerOptions merging;
  merging.delay = 60'000 * kMs;  // the order of stamps alone decides, not how busy the machine is
  live::LiveRecorder recorder(path, {}, merging, 2);
  for (int i = 0; i < 200; ++i) {
    // The second sensor's come ten at a time.
    recorder.add({{0, imuAt(kStart + 5 * i * kMs), hostNow()}});
    if (i % 10 != 9) continue;
    for (int k = i - 9; k <= i; ++k) {
      recorder.add({{1, test::rangeAt(kStart + (5 * k + 2) * kMs, 1), hostNow()}});
    }
  }
  recorder.close();
  const Content content = contentOf(path);
  EXPECT_EQ(content.stamps.size(), 400u);
  EXPECT_TRUE(std::is_sorted(content.stamps.begin(), content.stamps.end()));
  EXPECT_EQ(recorder.counts().aside, 0u);
}

}  // namespace
}  // namespace vir::rawlog
