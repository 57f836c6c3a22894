/// Videos as the images of a camera: their times, what is wrong with them, and what goes with them.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "image_store.h"
#include "input_error.h"
#include "recording.h"
#include "table_folder.h"
#include "video_frames.h"
#include "vir_test_video.h"

namespace vir::euroc {
namespace {

namespace fs = std::filesystem;

constexpr TimeNs kStart = 1'700'000'000'000'000'000;
constexpr TimeNs kMs = 1'000'000;
constexpr int kFrames = 30;

class Video : public ::testing::Test {
 protected:
  void SetUp() override {
    test::writeText(
        root() / "camchain.yaml",
        "cam0:\n  camera_model: pinhole\n  intrinsics: [40, 41, 31, 23]\n"
        "  distortion_model: radtan\n  distortion_coeffs: [0, 0, 0, 0]\n"
        "  resolution: [64, 48]\n  T_cam_imu: [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]\n");
    imu(kStart);
  }
  void imu(TimeNs start) {
    std::string text = "time,ax,ay,az,gx,gy,gz\n";
    for (int i = 0; i < 300; ++i)
      text += std::to_string(start + i * 5 * kMs) + ",0.1,0.2,9.8,0.01,0.02,0.03\n";
    test::writeText(root() / "imu.csv", text);
  }
  void times(const std::string& file, int rows, TimeNs step = 40 * kMs) {
    std::string text;
    for (int i = 0; i < rows; ++i) text += std::to_string(kStart + 7 * kMs + i * step) + "\n";
    test::writeText(root() / file, text);
  }
  fs::path clip() const { return root() / "clip.avi"; }
  fs::path root() const { return temp_.path(); }

  struct Content {
    std::vector<std::pair<TimeNs, int>> frames;  // with their grey
    std::size_t imu = 0;
    std::string notes, first_where;
    ProblemLog log;
    cv::Size size;
    std::vector<cv::Mat> pixels;
  };
  Content read(EurocOptions o) {
    o.section = "csv";
    if (o.source.empty()) o.source = root().string();
    ProblemLog log;
    Content c;
    {
      Recording recording(findTables(o), o, &log);
      Event e;
      while (recording.next(&e)) {
        if (std::holds_alternative<ImuSample>(e.what)) ++c.imu;
        const auto* image = std::get_if<ImageRow>(&e.what);
        if (image == nullptr) continue;
        if (c.frames.empty()) c.first_where = e.where;
        c.frames.emplace_back(e.t, static_cast<int>(std::lround(cv::mean(image->pixels)[0])));
        c.size = image->pixels.size();
        EXPECT_EQ(image->pixels.type(), CV_8UC1);
        c.pixels.push_back(image->pixels);
      }
    }
    for (const std::string& m : log.messages()) c.notes += m + "\n";
    c.log = log;
    return c;
  }
  Content read(const std::string& topics = "") {
    EurocOptions o;
    o.topics = topics;
    return read(o);
  }

  test::TempFolder temp_;
};

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

void expectGreys(const std::vector<std::pair<TimeNs, int>>& frames) {
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_NEAR(frames[i].second, test::greyOfFrame(static_cast<int>(i)), 3) << "frame " << i;
  }
}

TEST_F(Video, BesideAnImuIsItsCamera) {
  test::writeVideo(clip(), kFrames, 25);
  EXPECT_TRUE(isTableFolder(root().string()));
  EXPECT_TRUE(isTableFolder(clip().string()));
  const Content c = read();
  ASSERT_EQ(c.frames.size(), static_cast<std::size_t>(kFrames)) << c.notes;
  EXPECT_EQ(c.imu, 300u);
  expectGreys(c.frames);
  // The IMU's clock shows dates, the video counts from 0: both are put to begin together.
  for (int i = 0; i < kFrames; ++i) {
    EXPECT_NEAR(static_cast<double>(c.frames[static_cast<std::size_t>(i)].first - kStart),
                i * 40.0 * kMs, 1000);
  }
  EXPECT_TRUE(has(c.notes, "64x48, 25 Hz, 30 frames")) << c.notes;
  EXPECT_TRUE(has(c.notes, "the first frame was put at 1700000000.000 s, where the IMU begins"))
      << c.notes;
  EXPECT_EQ(c.log.get("damage"), 0);
  EXPECT_TRUE(has(c.first_where, "clip.avi, frame 1")) << c.first_where;
}

/// Rows that were handed out keep their pixels.
TEST_F(Video, FramesHaveBuffersOfTheirOwn) {
  test::writeVideo(clip(), 5, 25);
  const Content c = read();
  ASSERT_EQ(c.pixels.size(), 5u);
  for (int i = 0; i < 5; ++i) {
    EXPECT_NEAR(cv::mean(c.pixels[static_cast<std::size_t>(i)])[0], test::greyOfFrame(i), 3);
  }
}

TEST_F(Video, IsASourceByItselfWithTheTablesBesideIt) {
  test::writeVideo(clip(), kFrames, 25);
  test::writeVideo(root() / "another.avi", 4, 25);
  EurocOptions o;
  o.source = clip().string();
  EXPECT_EQ(read(o).frames.size(), static_cast<std::size_t>(kFrames));
  o.topics = "imu=" + (root() / "imu.csv").string();
  EXPECT_EQ(read(o).imu, 300u);
  o.source = root().string();
  o.topics = "camera=another.avi";
  EXPECT_EQ(read(o).frames.size(), 4u);
}

TEST_F(Video, AClockThatBeginsWithTheVideoIsKept) {
  imu(kMs);
  test::writeVideo(clip(), kFrames, 25);
  EXPECT_EQ(read().frames.at(0).first, 0);
  EurocOptions o;
  o.video_start = "0.123456789";
  EXPECT_EQ(read(o).frames.at(0).first, 123'456'789);
  o.video_start = "1700000000.123456789";
  EXPECT_EQ(read(o).frames.at(0).first, kStart + 123'456'789) << "not by way of a double";
  for (const char* wrong : {"", "soon", "-1"}) {
    o.video_start = wrong;
    EXPECT_THROW(read(o), InputError) << wrong;
  }
}

TEST_F(Video, ATableOfTimesGoesBefore) {
  test::writeVideo(clip(), kFrames, 25);
  times("frame_times.csv", kFrames);
  const Content c = read();
  ASSERT_EQ(c.frames.size(), static_cast<std::size_t>(kFrames)) << c.notes;
  EXPECT_EQ(c.frames[0].first, kStart + 7 * kMs);
  EXPECT_EQ(c.frames[29].first, kStart + 7 * kMs + 29 * 40 * kMs);
  EXPECT_TRUE(has(c.notes, "taken for the times of the frames of clip.avi")) << c.notes;
  EXPECT_EQ(c.log.counters().size(), 0u) << c.notes;
  EXPECT_EQ(read("times=none").frames.at(0).first, kStart);
}

/// A column among others, named by hand, and rows that hold no time in the middle.
TEST_F(Video, ARowWithoutATimeCostsItsFrameOnly) {
  test::writeVideo(clip(), kFrames, 25);
  std::string text = "Timestamp[nanosecond],fx[px],exposure\n";
  for (int i = 0; i < kFrames; ++i) {
    const std::string t = i == 4   ? "-5"
                          : i == 9 ? "nothing"
                                   : std::to_string(kStart + i * 40 * kMs);
    text += t + ",450.2,0.01\n";
  }
  test::writeText(root() / "movie_metadata.csv", text);
  const Content c = read("times=movie_metadata.csv");
  ASSERT_EQ(c.frames.size(), 28u) << c.notes;
  EXPECT_EQ(c.log.get("image_before_zero"), 1) << c.notes;
  EXPECT_EQ(c.log.get("image_malformed"), 1) << c.notes;
  EXPECT_EQ(c.frames[4].first, kStart + 5 * 40 * kMs);
  EXPECT_NEAR(c.frames[4].second, test::greyOfFrame(5), 3) << "times and frames stay together";
}

TEST_F(Video, TooFewTimes) {
  test::writeVideo(clip(), kFrames, 25);
  times("frame_times.csv", 26);
  const Content c = read();
  EXPECT_EQ(c.frames.size(), 26u);
  EXPECT_EQ(c.log.get("image_without_stamp"), 4) << c.notes;
  EXPECT_TRUE(has(c.notes, "has 26 times for 30 frames")) << c.notes;
}

TEST_F(Video, TooManyTimes) {
  test::writeVideo(clip(), kFrames, 25);
  times("frame_times.csv", 33);
  const Content c = read();
  EXPECT_EQ(c.frames.size(), 30u);
  EXPECT_EQ(c.log.get("image_times_left_over"), 3) << c.notes;
  EXPECT_TRUE(has(c.notes, "has 33 times for 30 frames")) << c.notes;
}

/// A row that is missing in the middle shifts all that follow: where that is shows.
TEST_F(Video, ATimeThatIsMissingInTheMiddleIsSeen) {
  test::writeVideo(clip(), kFrames, 25);
  std::string text;
  for (int i = 0; i < kFrames; ++i) {
    if (i != 12) text += std::to_string(kStart + i * 40 * kMs) + "\n";
  }
  test::writeText(root() / "frame_times.csv", text);
  const Content c = read();
  EXPECT_EQ(c.log.get("image_times_disagree"), 1) << c.notes;
  EXPECT_TRUE(has(c.log.first("image_times_disagree"),
                  "clip.avi, frame 13: is 0.0800 s after the frame before by the table, 0.0400 s"))
      << c.log.first("image_times_disagree");
}

TEST_F(Video, TimesThatDoNotGoOnAreCounted) {
  test::writeVideo(clip(), 6, 25);
  std::string text;
  for (const int ms : {0, 40, 40, 20, 160, 200}) text += std::to_string(kStart + ms * kMs) + "\n";
  test::writeText(root() / "frame_times.csv", text);
  const Content c = read();
  EXPECT_EQ(c.frames.size(), 4u);
  EXPECT_EQ(c.log.get("image_repeated"), 1);
  EXPECT_EQ(c.log.get("image_too_late"), 1);
}

/// Phones: the time between frames varies with the light, and the file says that they were held
/// upright.
TEST_F(Video, VariableFrameRate) {
  const fs::path mp4 = root() / "clip.mp4";
  test::writeVideo(mp4, kFrames, 25, "mp4v");
  test::Mp4Edit edit(mp4);
  const std::uint32_t unit = edit.unitsPerSecond() / 25;
  std::vector<std::uint32_t> lengths;
  for (int i = 0; i < kFrames; ++i) lengths.push_back(i % 2 == 0 ? unit / 2 : unit + unit / 2);
  edit.setFrameLengths(lengths);
  edit.save();
  const Content c = read();
  ASSERT_EQ(c.frames.size(), static_cast<std::size_t>(kFrames)) << c.notes;
  for (std::size_t i = 0; i < c.frames.size(); ++i) {
    const double expected = 40.0 * static_cast<double>(i) - (i % 2 == 1 ? 20 : 0);
    EXPECT_NEAR(static_cast<double>(c.frames[i].first - kStart) * 1e-6, expected, 0.2) << i;
  }
  expectGreys(c.frames);
}

TEST_F(Video, IsNotTurnedUnlessAskedFor) {
  const fs::path mp4 = root() / "clip.mp4";
  test::writeVideo(mp4, 5, 25, "mp4v", {64, 48}, true);
  test::Mp4Edit edit(mp4);
  edit.turnBy90();
  edit.save();
  const Content as_taken = read();
  EXPECT_EQ(as_taken.size, cv::Size(64, 48));
  EXPECT_TRUE(has(as_taken.notes,
                  "players turn it as its file says, which is not followed here: "
                  "its frames are as the camera gave them"))
      << as_taken.notes;
  EXPECT_GT(as_taken.pixels[0].at<std::uint8_t>(24, 8), 200) << "the bright half is on the left";
  EurocOptions o;
  o.turn_video = "90";
  const Content turned = read(o);
  EXPECT_EQ(turned.size, cv::Size(48, 64));
  EXPECT_GT(turned.pixels[0].at<std::uint8_t>(8, 24), 200) << "the bright half is on top";
  EXPECT_TRUE(has(turned.notes, "was it made with turned ones? (turn_video)")) << turned.notes;
}

TEST_F(Video, ThatIsCutGivesWhatIsThereAndSaysSo) {
  test::writeVideo(clip(), kFrames, 25);
  const std::string whole = test::readText(clip());
  test::writeText(clip(), whole.substr(0, whole.size() * 7 / 10));
  const Content c = read();
  EXPECT_GT(c.frames.size(), 5u);
  EXPECT_LT(c.frames.size(), 28u);
  EXPECT_EQ(c.log.get("damage"), 1) << c.notes;
  EXPECT_TRUE(has(c.notes, "is damaged or cut off after frame")) << c.notes;
}

/// An mp4 whose index, at its end, is gone; text; nothing at all.
TEST_F(Video, ThatCannotBeOpenedIsNamed) {
  const fs::path mp4 = root() / "clip.mp4";
  test::writeVideo(mp4, kFrames, 25, "mp4v");
  const std::string whole = test::readText(mp4);
  for (const std::string& bytes :
       {whole.substr(0, whole.size() / 2), std::string("no video\n"), std::string()}) {
    test::writeText(mp4, bytes);
    try {
      read();
      FAIL() << "no complaint about " << bytes.size() << " bytes";
    } catch (const InputError& e) {
      EXPECT_TRUE(has(e.what(), "clip.mp4: cannot be opened as a video")) << e.what();
    }
  }
}

/// Wherever it is cut, and whatever bytes are changed: frames, or a word.
TEST_F(Video, DamageDoesNoHarm) {
  test::writeVideo(clip(), 6, 25);
  const std::string whole = test::readText(clip());
  std::uint32_t random = 4711;
  const auto next = [&] { return random = random * 1664525u + 1013904223u; };
  for (int round = 0; round < 60; ++round) {
    std::string bytes = whole;
    if (round < 20) bytes.resize(whole.size() * static_cast<std::size_t>(round) / 20);
    for (int i = 0; i < 8 && round >= 20; ++i)
      bytes[(next() >> 8) % bytes.size()] = static_cast<char>(next() >> 24);
    test::writeText(clip(), bytes);
    try {
      TimeNs last = -1;
      for (const auto& [t, grey] : read().frames) {
        EXPECT_GT(t, last);
        last = t;
      }
    } catch (const InputError&) {
    }
  }
}

TEST_F(Video, FramesBecomeFilesOfTheRawlog) {
  ProblemLog log;
  ImageStore store(ImageMode::link, (root() / "out").string(), "CAM0", 64, 48, &log);
  store.setTarget(32, 24);
  StoredImage stored;
  ASSERT_TRUE(
      store.store(5, cv::Mat(48, 64, CV_8UC1, cv::Scalar(77)), "clip.mp4, frame 1", &stored));
  EXPECT_EQ(stored.external_name, "CAM0_5.png");
  const cv::Mat back = cv::imread((root() / "out/CAM0_5.png").string(), cv::IMREAD_UNCHANGED);
  EXPECT_EQ(back.size(), cv::Size(32, 24));
  EXPECT_EQ(back.at<std::uint8_t>(3, 3), 77);
  EXPECT_FALSE(
      store.store(6, cv::Mat(10, 10, CV_8UC1, cv::Scalar(1)), "clip.mp4, frame 2", &stored));
  EXPECT_EQ(log.get("image_wrong_size"), 1);
}

TEST_F(Video, IsListed) {
  test::writeVideo(clip(), kFrames, 25);
  test::writeText(root() / "broken.mp4", "x");
  const std::string list = listTables(root().string());
  EXPECT_TRUE(has(list, "clip.avi: video, 64x48, 25 Hz, 30 frames")) << list;
  EXPECT_TRUE(has(list, "broken.mp4: cannot be opened as a video")) << list;
  EXPECT_EQ(listTables(clip().string()), list);
}

TEST_F(Video, ImagesGoBeforeIt) {
  test::writeVideo(clip(), kFrames, 25);
  fs::create_directories(root() / "frames");
  for (int i = 0; i < 3; ++i) {
    const std::string name = std::to_string(kStart + i * 50 * kMs) + ".png";
    cv::imwrite((root() / "frames" / name).string(), cv::Mat(48, 64, CV_8UC1, cv::Scalar(9)));
  }
  EurocOptions o;
  o.section = "csv";
  o.source = root().string();
  const Folder folder = findTables(o);
  ASSERT_EQ(folder.cameras.size(), 1u);
  EXPECT_TRUE(folder.cameras[0].video.empty());
  std::string notes;
  for (const std::string& n : folder.notes) notes += n + "\n";
  EXPECT_TRUE(has(notes, "clip.avi not read, the camera is frames")) << notes;
}

}  // namespace
}  // namespace vir::euroc
