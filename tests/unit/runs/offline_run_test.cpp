/// A run from rawlog to result files, with a test estimator in place of the real one.
#include "vir/runs/offline_run.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "vir/core/settings.h"
#include "vir/rawlog/labels.h"
#include "vir/roles/estimator_registry.h"
#include "vir/roles/plugin_loader.h"
#include "vir_test_paths.h"
#include "vir_test_rawlog.h"
#include "vir_test_temp_folder.h"

namespace vir::runs {
namespace {

using test::kMs;
using test::kStart;

class OfflineRunTest : public testing::Test {
 protected:
  void SetUp() override {
    roles::loadPlugin(test::buildDir() + "/tests/fixtures/good/libfixture_estimator.so");
    rawlog_ = (folder_ / "a.rawlog").string();
  }

  results::RunSummary run(const std::vector<std::string>& assignments = {},
                          double start_offset_s = 0, double duration_s = 0) {
    const auto estimator = roles::estimatorSettings("counting");
    Settings settings;
    for (const std::string& a : assignments) settings.set(a);
    SettingsReader reader(settings);
    estimator->describe(reader);
    const results::ResultsFolder results((folder_ / "out").string());
    OfflineRunHooks hooks;
    hooks.log = [&](LogLevel, const std::string& text) { log_ += text + "\n"; };
    hooks.observers = observers_;
    hooks.stop = [&] { return stop_after_ >= 0 && polls_++ > stop_after_; };
    OfflineRunOptions options;
    options.rawlog = rawlog_;
    options.start_offset_s = start_offset_s;
    options.duration_s = duration_s;
    options.inputs = inputs_;
    return runOffline(*estimator->create(hooks.log), options, results, hooks);
  }

  std::string file(const std::string& name) { return test::readText(folder_ / ("out/" + name)); }
  static long lines(const std::string& text) { return std::count(text.begin(), text.end(), '\n'); }
  static long counter(const results::RunSummary& s, const std::string& name) {
    for (const auto& [key, value] : s.counters) {
      if (key == name) return value;
    }
    return 0;
  }

  test::TempFolder folder_;
  std::string rawlog_, log_;
  std::vector<results::RunObserver*> observers_;
  std::vector<roles::EstimatorInput> inputs_;
  long stop_after_ = -1, polls_ = 0;
};

TEST_F(OfflineRunTest, ImagesOfOtherCamerasArePassedOverAndCounted) {
  test::writeRecording(rawlog_, 30);
  inputs_ = {{roles::InputKind::image, rawlog::kCameraLabel, 1}};
  const results::RunSummary own = run();
  EXPECT_EQ(own.frames, 30);
  EXPECT_EQ(counter(own, "images_of_other_cameras"), 0);
  inputs_ = {{roles::InputKind::image, "CAM7", 1}};
  const results::RunSummary other = run();
  EXPECT_EQ(other.frames, 0);
  EXPECT_EQ(other.poses, 0);
  EXPECT_EQ(counter(other, "images_of_other_cameras"), 30);
}

TEST_F(OfflineRunTest, WholeRecording) {
  test::writeRecording(rawlog_, 30);
  const results::RunSummary s = run();
  EXPECT_EQ(s.error, "");
  EXPECT_EQ(s.frames, 30);
  EXPECT_EQ(s.poses, 28);  // the test estimator starts with the third image
  ASSERT_TRUE(s.init_time_s);
  EXPECT_DOUBLE_EQ(*s.init_time_s, 0.1);
  EXPECT_DOUBLE_EQ(s.duration_s, 29 * 0.05);
  EXPECT_NEAR(s.path_m, 2.7, 1e-9);
  ASSERT_TRUE(s.ate_posyaw_m);
  EXPECT_LT(*s.ate_posyaw_m, 1e-9);  // the ground truth moves in the same way
  EXPECT_EQ(s.longest_wait_reason, "waiting, as told");
  EXPECT_EQ(counter(s, "imu_samples"), 300);
  EXPECT_TRUE(s.warnings.empty()) << log_;
  EXPECT_EQ(lines(file("trajectory.tum")), 28);
  EXPECT_EQ(file("trajectory.tum").substr(0, 32), "1700000000.125000000 0.200000000");
  EXPECT_EQ(lines(file("trajectory_smoothed.tum")), 5);  // images 5, 10, ... 25
  EXPECT_EQ(lines(file("frames.csv")), 31);
  EXPECT_NE(file("landmarks.ply").find("element vertex 1\n"), std::string::npos);
}

TEST_F(OfflineRunTest, ARevisedKeyframeIsWrittenAsItWasLastToldOf) {
  test::writeRecording(rawlog_, 30);
  EXPECT_EQ(run().error, "");
  const std::string plain = file("trajectory_smoothed.tum"), causal = file("trajectory.tum");
  EXPECT_EQ(run({"Estimator.revise_at=12"}).error, "");
  const std::string revised = file("trajectory_smoothed.tum");
  // The window let go of the first keyframe at image 12, 1 m higher than it was.
  EXPECT_EQ(lines(revised), lines(plain));
  EXPECT_EQ(revised.substr(0, revised.find('\n')),
            plain.substr(0, plain.find(' ')) +
                " 0.000000000 0.000000000 1.000000000 0.000000000 0.000000000 0.000000000 "
                "1.000000000");
  EXPECT_EQ(revised.substr(revised.find('\n')), plain.substr(plain.find('\n')));
  EXPECT_EQ(file("trajectory.tum"), causal) << "the causal trajectory is never revised";
}

/// Notes what it is told.
class Noting : public results::RunObserver {
 public:
  void onObservation(const mrpt::obs::CObservation& o) override {
    ++observations;
    truth += o.sensorLabel == "GT" ? 1 : 0;
  }
  void onOutput(const roles::EstimatorOutput& output, const roles::Estimator& e) override {
    states += static_cast<long>(output.states.size());
    landmarks = e.landmarks().size();
    EXPECT_FALSE(ended);
  }
  void onEnd(const roles::Estimator&, results::RunSummary* summary) override {
    ended = true;
    summary->warnings.push_back("noted");
  }
  long observations = 0, truth = 0, states = 0;
  std::size_t landmarks = 0;
  bool ended = false;
};

TEST_F(OfflineRunTest, ObserversAreToldOfEverythingButTheTruth) {
  test::writeRecording(rawlog_, 30);
  Noting noting;
  observers_.push_back(&noting);
  const results::RunSummary s = run();
  EXPECT_EQ(noting.observations, 30 + 300);
  EXPECT_EQ(noting.truth, 0);
  EXPECT_EQ(noting.states, 30);
  EXPECT_EQ(noting.landmarks, 1u);
  EXPECT_TRUE(noting.ended);
  EXPECT_EQ(s.warnings, std::vector<std::string>{"noted"});
  EXPECT_NE(file("report.html").find("noted"), std::string::npos);
}

/// What was told of images, in order: the first pixel.
struct SeenImages : results::RunObserver {
  void onObservation(const mrpt::obs::CObservation& o) override {
    const auto* image = dynamic_cast<const mrpt::obs::CObservationImage*>(&o);
    if (image == nullptr) return;
    EXPECT_FALSE(image->image.isEmpty());
    first_pixels.push_back(*image->image.ptr<std::uint8_t>(0, 0));
  }
  std::vector<int> first_pixels;
};

/// They are decoded before their turn, and by another thread.
TEST_F(OfflineRunTest, ImagesOnTheDiskComeInOrderAndBadOnesAreNamedInTheirTurn) {
  const std::filesystem::path images = rawlog::RawlogWriter::imageFolderOf(rawlog_);
  std::filesystem::create_directories(images);
  rawlog::RawlogWriter writer(rawlog_);
  const auto bad = [](int i) { return i == 4 || i == 9 || i == 10; };
  std::vector<int> good;
  for (int i = 0; i < 40; ++i) {
    const TimeNs t = kStart + 50 * i * kMs;
    writer.write(*test::imuAt(t - 20 * kMs));
    const std::string name = std::to_string(i) + ".png";
    const auto image = test::imageAt(t, i);
    image->image.saveToFile((images / name).string());
    if (bad(i)) test::writeText(images / name, "no image");
    if (!bad(i)) good.push_back(i);
    image->image.setExternalStorage(name);
    writer.write(*image);
  }
  writer.finish();
  SeenImages seen;
  observers_.push_back(&seen);
  const results::RunSummary s = run();
  EXPECT_EQ(seen.first_pixels, good);
  EXPECT_EQ(s.frames, 37);
  EXPECT_EQ(counter(s, "images_unreadable"), 3);
  ASSERT_EQ(s.warnings.size(), 1u);
  EXPECT_NE(s.warnings[0].find("image at 1700000000.200"), std::string::npos) << s.warnings[0];
}

/// Whoever stops in between leaves images behind that have been begun.
TEST_F(OfflineRunTest, AStoppedRunWaitsForNoImage) {
  test::writeRecording(rawlog_, 30);
  SeenImages seen;
  observers_.push_back(&seen);
  stop_after_ = 61;  // observations: ten of the IMU, an image and a pose of the truth, and so on
  const results::RunSummary s = run();
  EXPECT_TRUE(s.interrupted);
  EXPECT_EQ(s.frames, 5);
  EXPECT_EQ(seen.first_pixels, (std::vector<int>{0, 1, 2, 3, 4}));
}

TEST_F(OfflineRunTest, SameInputSameBytes) {
  test::writeRecording(rawlog_, 20);
  run();
  const std::string first = file("trajectory.tum") + file("frames.csv");
  run();
  EXPECT_EQ(file("trajectory.tum") + file("frames.csv"), first);
}

TEST_F(OfflineRunTest, StartOffsetLeavesOutWhatIsBefore) {
  test::writeRecording(rawlog_, 30);
  const results::RunSummary s = run({}, 0.5);
  EXPECT_EQ(s.frames, 20);
  EXPECT_EQ(counter(s, "imu_samples"), 195);  // images are 25 ms after the IMU's start
  EXPECT_DOUBLE_EQ(*s.init_time_s, 0.1);
}

TEST_F(OfflineRunTest, AStretchOfTheRecording) {
  test::writeRecording(rawlog_, 30);
  const results::RunSummary s = run({}, 0.5, 0.3);
  EXPECT_EQ(s.frames, 7);
  EXPECT_DOUBLE_EQ(s.duration_s, 6 * 0.05);
  EXPECT_EQ(counter(s, "imu_samples"), 61);
  EXPECT_EQ(run({}, 0, 0.3).frames, 7);
  EXPECT_EQ(run({}, 0, 100).frames, 30);
}

TEST_F(OfflineRunTest, StartOffsetBeyondTheEnd) {
  test::writeRecording(rawlog_, 5);
  const results::RunSummary s = run({}, 100);
  EXPECT_EQ(s.frames, 0);
  EXPECT_EQ(s.poses, 0);
  EXPECT_FALSE(s.init_time_s);
  EXPECT_NE(log_.find("no usable image and no odometry"), std::string::npos);
}

TEST_F(OfflineRunTest, EstimatorThatThrowsStillLeavesResults) {
  test::writeRecording(rawlog_, 30);
  const results::RunSummary s = run({"Estimator.throw_at=10"});
  EXPECT_EQ(s.error, "told to throw");
  EXPECT_EQ(s.poses, 8);
  EXPECT_EQ(lines(file("trajectory.tum")), 8);
  EXPECT_NE(log_.find("the run ends early: told to throw"), std::string::npos);
}

TEST_F(OfflineRunTest, NanNeverReachesAFile) {
  test::writeRecording(rawlog_, 30);
  const results::RunSummary s = run({"Estimator.nan_at=10"});
  EXPECT_EQ(s.poses, 27);
  EXPECT_EQ(counter(s, "poses_not_finite"), 2);  // in the path and as a keyframe
  for (const char* name : {"trajectory.tum", "trajectory_smoothed.tum", "frames.csv"}) {
    EXPECT_EQ(file(name).find("nan"), std::string::npos) << name;
  }
}

TEST_F(OfflineRunTest, CutRecording) {
  test::writeRecording(rawlog_, 300);
  const std::string whole = test::readText(rawlog_);
  test::writeText(rawlog_, whole.substr(0, whole.size() / 2));
  const results::RunSummary s = run();
  EXPECT_GT(s.poses, 20);
  EXPECT_LT(s.poses, 290);
  ASSERT_EQ(s.warnings.size(), 1u);
  EXPECT_NE(s.warnings[0].find("damaged or cut off after"), std::string::npos);
}

TEST_F(OfflineRunTest, ImagesThatAreMissingOrEmpty) {
  {
    rawlog::RawlogWriter writer(rawlog_);
    for (int i = 0; i < 10; ++i) {
      const auto image = test::imageAt(kStart + 50 * i * kMs);
      if (i == 3) image->image.setExternalStorage("not_there.png");
      if (i == 4) image->image = mrpt::img::CImage();
      writer.write(*image);
    }
    writer.finish();
  }
  const results::RunSummary s = run();
  EXPECT_EQ(s.error, "");
  EXPECT_EQ(s.frames, 8);
  EXPECT_EQ(counter(s, "images_unreadable"), 2);
  EXPECT_EQ(s.warnings.size(), 1u);
}

TEST_F(OfflineRunTest, StoppedRunKeepsWhatThereIs) {
  test::writeRecording(rawlog_, 100);
  stop_after_ = 1000;
  const results::RunSummary s = run();
  EXPECT_TRUE(s.interrupted);
  EXPECT_GT(s.poses, 10);
  EXPECT_LT(s.poses, 95);
  EXPECT_EQ(lines(file("trajectory.tum")), s.poses);
}

TEST_F(OfflineRunTest, RepeatedAndLateObservationsAreReported) {
  {
    rawlog::RawlogWriter writer(rawlog_);
    for (int i = 0; i < 60; ++i) {
      writer.write(*test::imageAt(kStart + 50 * i * kMs));
      if (i == 7) writer.write(*test::imageAt(kStart + 50 * i * kMs));
      if (i == 50) writer.write(*test::imageAt(kStart + kMs));
    }
    writer.finish();
  }
  const results::RunSummary s = run();
  EXPECT_EQ(s.frames, 60);
  EXPECT_EQ(counter(s, "repeated_CAM0"), 1);
  EXPECT_EQ(counter(s, "late_CAM0"), 1);
  EXPECT_EQ(s.warnings.size(), 2u);
}

TEST_F(OfflineRunTest, NoRecording) { EXPECT_THROW(run(), std::runtime_error); }

}  // namespace
}  // namespace vir::runs
