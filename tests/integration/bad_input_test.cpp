/// Recordings as they come from the field: each fault is put into a good recording, and the program
/// must say what happened, write no NaN and go on afterwards.
#include <gtest/gtest.h>

#include <regex>

#include "end_to_end.h"
#include "vir_test_derived_recording.h"

namespace vir {
namespace {

using test::contains;
using test::DerivedRecording;
using test::RunResult;

constexpr double kLength = 11;  // [s] of the recording
constexpr double kFrom = 5;     // the fault begins, well after the start

class BadInput : public testing::Test {
 protected:
  void SetUp() override {
    VIR_REQUIRE_DATA(source, test::kRendered);
    recording_ = std::make_unique<DerivedRecording>(source, kLength);
    truth_ = test::groundTruth(source);
  }

  RunResult importAndRun(bool last_imu_row_cut = false) {
    DerivedRecording& rec = *recording_;
    const std::string rawlog = (rec.temp() / "a.rawlog").string();
    import_ = test::importEuroc(rec.write(last_imu_row_cut), rawlog);
    EXPECT_EQ(import_.code, 0) << import_.text;
    const RunResult r = test::runVir(rawlog, (rec.temp() / "out").string());
    EXPECT_EQ(r.outcome.code, 0) << r.outcome.text;
    EXPECT_EQ(test::notFinite(r.folder), "");
    return r;
  }

  /// Largest position error between `from` and `to` seconds, aligned on what is before `kFrom`.
  double errorAfter(const RunResult& r, double from = kFrom, double to = kLength + 1) {
    Trajectory used;
    for (const StampedPose& p : r.trajectory) {
      const double t = toSeconds(p.t - recording_->at(0));
      if (t < kFrom || (t >= from && t < to)) used.push_back(p);
    }
    if (used.empty()) return 1e9;
    const test::SplitError e = test::splitError(truth_, used, recording_->at(kFrom));
    std::printf("measured %.1f to %.1f s: %.4f m RMS, %.4f m at most; before %.4f m; resets %d\n",
                from, to, e.after.rmse, e.after.max, e.before, r.summary["resets"].get<int>());
    return e.after.count > 0 ? e.after.max : 1e9;
  }

  void expectImportSays(const std::vector<std::string>& parts) const {
    // Columns are lined up with blanks; how many is not the point.
    const std::string text = std::regex_replace(import_.text, std::regex(" +"), " ");
    for (const std::string& part : parts) {
      EXPECT_TRUE(contains(text, part)) << part << " is not in\n" << import_.text;
    }
  }

  template <typename Rows>
  void erase(Rows* rows, double from, double to) {
    rows->erase(std::remove_if(rows->begin(), rows->end(),
                               [&](const auto& r) { return recording_->between(r.t, from, to); }),
                rows->end());
  }

  std::unique_ptr<DerivedRecording> recording_;
  Trajectory truth_;
  test::Outcome import_;
};

// The bounds on the position error are about twice what was measured.

TEST_F(BadInput, NothingWrong) {
  const RunResult r = importAndRun();
  EXPECT_LT(errorAfter(r), 0.01);
  EXPECT_EQ(r.summary["resets"], 0);
  EXPECT_TRUE(r.summary["warnings"].empty()) << r.summary["warnings"];
}

TEST_F(BadInput, NoImuForTwoSecondsIsBridgedByTheImages) {
  erase(&recording_->imu, kFrom, kFrom + 2);
  const RunResult r = importAndRun();
  expectImportSays({"imu_gap 1\n", "nothing for 2.005 s before"});
  EXPECT_EQ(r.summary["resets"], 0);
  EXPECT_TRUE(r.warns("IMU readings missing")) << r.summary;
  EXPECT_LT(errorAfter(r), 0.02);
}

/// Bridged by interpolation even two seconds went 35 m astray: no pose without readings for long,
/// then a new segment.
TEST_F(BadInput, NoImuForLongStartsANewSegment) {
  const double from = 3, to = 7.5;
  erase(&recording_->imu, from, to);
  const RunResult r = importAndRun();
  expectImportSays({"imu_gap 1\n", "nothing for 4.505 s before"});
  EXPECT_EQ(r.summary["resets"], 1);
  EXPECT_TRUE(r.warns("the IMU was silent")) << r.summary;
  const double last = toSeconds(r.trajectory.back().t - recording_->at(0));
  EXPECT_GT(last, to + 1.5);  // it started again
  for (const auto& pose : r.trajectory) {
    const double t = toSeconds(pose.t - recording_->at(0));
    EXPECT_FALSE(t > from + 0.06 && t < to) << "a pose without IMU at " << t;
  }
}

TEST_F(BadInput, NoImagesForTwoSeconds) {
  erase(&recording_->images, kFrom, kFrom + 2);
  const RunResult r = importAndRun();
  EXPECT_LT(errorAfter(r, kFrom + 2), 0.03);
  EXPECT_EQ(r.summary["resets"], 0);
  EXPECT_EQ(r.counter("image_gaps"), 1);
  EXPECT_TRUE(r.warns("no image for 2.05")) << r.summary;
}

TEST_F(BadInput, ACameraThatStopsIsSaid) {
  constexpr double kEnd = 1e3;
  erase(&recording_->images, kFrom, kEnd);
  const RunResult r = importAndRun();
  EXPECT_LT(toSeconds(r.trajectory.back().t - recording_->at(0)), kFrom);
  EXPECT_TRUE(r.warns("no image in the last ")) << r.summary;
  EXPECT_TRUE(r.warns("no poses are given there")) << r.summary;
}

TEST_F(BadInput, BlackForOneSecond) {
  recording_->addPicture("black.png", cv::Mat(480, 752, CV_8UC1, cv::Scalar(0)));
  int black = 0;
  for (auto& image : recording_->images) {
    if (!recording_->between(image.t, kFrom, kFrom + 1)) continue;
    image.file = "black.png";
    ++black;
  }
  const RunResult r = importAndRun();
  EXPECT_LT(errorAfter(r), 0.025);
  EXPECT_EQ(r.summary["resets"], 0);
  EXPECT_EQ(black, 20);
  EXPECT_EQ(r.counter("images_unusable"), black);
}

/// Believed, they led 2 m astray on this recording.
TEST_F(BadInput, ImagesWithEachOthersStamps) {
  auto& images = recording_->images;
  for (std::size_t i = 50; i + 1 < images.size(); i += 50) {
    std::swap(images[i].file, images[i + 1].file);
  }
  const RunResult r = importAndRun();
  EXPECT_LT(errorAfter(r), 0.02);
  EXPECT_EQ(r.summary["resets"], 0);
  EXPECT_EQ(r.summary["verdict"], "good") << r.summary["doubts"];
  EXPECT_EQ(r.counter("images_misstamped"), 8);
  EXPECT_EQ(r.counter("imu_contradicted"), 0);
  EXPECT_TRUE(r.warns("shows what was seen 50 ms later")) << r.summary;
}

TEST_F(BadInput, ImageStampsRepeatedAndOutOfOrder) {
  auto& images = recording_->images;
  for (std::size_t i = 100; i + 10 < images.size(); i += 20) {
    std::swap(images[i], images[i + 1]);
    images[i + 5].t = images[i + 4].t;
  }
  const RunResult r = importAndRun();
  expectImportSays({"image_out_of_order 6\n", "image_repeated 6\n", "images 215\n",
                    "cam0/data.csv:107: a second row with the stamp"});
  EXPECT_LT(errorAfter(r), 0.0125);
  EXPECT_EQ(r.summary["resets"], 0);
  EXPECT_EQ(r.counter("images"), 215);
}

TEST_F(BadInput, ImuRowsRepeatedAndOutOfOrder) {
  auto& imu = recording_->imu;
  for (std::size_t i = 1000; i + 50 < imu.size(); i += 100) {
    std::swap(imu[i], imu[i + 3]);
    imu.insert(imu.begin() + static_cast<std::ptrdiff_t>(i) + 10, imu[i + 9]);
  }
  const RunResult r = importAndRun();
  expectImportSays({"imu_repeated 12\n", "imu_out_of_order 36\n", "imu_samples 2209\n",
                    "imu0/data.csv:1012: a second row with the stamp"});
  EXPECT_LT(errorAfter(r), 0.01);
  EXPECT_EQ(r.summary["resets"], 0);
}

/// Holding the last reading led 6 m astray within 2 s, with poses that claimed to be valid.
TEST_F(BadInput, ImuCutOffInMidLineIsSaidAndGivesNoWrongPoses) {
  erase(&recording_->imu, kFrom + 4, 1e6);
  const RunResult r = importAndRun(true);
  expectImportSays({"imu_cut_line 1\n", "its last line may be cut and is not used"});
  EXPECT_LT(errorAfter(r, kFrom, kFrom + 4), 0.01);
  EXPECT_TRUE(r.warns("the IMU was silent")) << r.summary;
  const double last = toSeconds(r.trajectory.back().t - recording_->at(0));
  EXPECT_LT(last, kFrom + 4.2) << r.summary;
  EXPECT_GT(r.counter("images_without_imu"), 30) << r.summary;
}

TEST_F(BadInput, ReadingsAtTheEndOfTheSensorsRangeAreSaid) {
  auto& imu = recording_->imu;
  const auto first = std::find_if(imu.begin(), imu.end(), [&](const auto& r) {
    return recording_->between(r.t, kFrom, kFrom + 1);
  });
  for (int i = 0; i < 4; ++i) {
    auto& row = first[i];  // t, rates, accelerations
    const std::size_t last = row.text.rfind(',');
    row.text = row.text.substr(0, last + 1) + "19.6133";
  }
  const RunResult r = importAndRun();
  EXPECT_EQ(r.counter("imu_saturated"), 4);
  EXPECT_TRUE(
      r.warns("4 IMU readings are at the end of the sensor's range, longest for 0.015 s "
              "(accelerometer z at 19.61 m/s^2)"))
      << r.summary["warnings"];
}

TEST_F(BadInput, ImagesOfAnotherSize) {
  int other = 0;
  for (auto& image : recording_->images) {
    if (!recording_->between(image.t, kFrom, kFrom + 0.5)) continue;
    cv::Mat small;
    cv::resize(recording_->picture(image), small, cv::Size(376, 240));
    image.file = "small" + std::to_string(++other) + ".png";
    recording_->addPicture(image.file, small);
  }
  const RunResult r = importAndRun();
  EXPECT_EQ(other, 10);
  expectImportSays({"image_wrong_size 10\n", "has 376x240 pixels, the calibration 752x480"});
  EXPECT_LT(errorAfter(r), 0.0125);
  EXPECT_EQ(r.summary["resets"], 0);
  EXPECT_TRUE(r.warns("no image for 0.55")) << r.summary;
}

TEST_F(BadInput, NoCalibration) {
  const std::string folder = recording_->write();
  std::filesystem::remove(recording_->folder() / "mav0/cam0/sensor.yaml");
  import_ = test::importEuroc(folder, (recording_->temp() / "a.rawlog").string());
  EXPECT_EQ(import_.code, 1) << import_.text;
  expectImportSays({"cam0/sensor.yaml: no such file", "the calibration is needed"});
  EXPECT_FALSE(std::filesystem::exists(recording_->temp() / "a.rawlog"));
}

TEST(EmptyFolder, IsNamedAndNothingIsWritten) {
  const test::TempFolder folder;
  std::filesystem::create_directories(folder / "empty");
  const auto import =
      test::importEuroc((folder / "empty").string(), (folder / "a.rawlog").string());
  EXPECT_EQ(import.code, 1) << import.text;
  EXPECT_TRUE(contains(import.text, "empty: holds no folder mav0")) << import.text;
  EXPECT_FALSE(std::filesystem::exists(folder / "a.rawlog"));
}

}  // namespace
}  // namespace vir
