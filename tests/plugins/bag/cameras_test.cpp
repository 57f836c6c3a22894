/// Which cameras a bag has, and which topics are one of them once more.
#include <gtest/gtest.h>

#include <initializer_list>

#include "camera_choice.h"
#include "recording_fixture.h"

namespace vir::bag {
namespace {

struct Images {
  const char* topic;
  const char* frame;
  bool compressed = false, floats = false;
};

Survey surveyOf(std::initializer_list<Images> all) {
  Survey s;
  for (const Images& i : all) {
    TopicInfo& info = s.topics[i.topic];
    info.topic = i.topic;
    info.frame = i.frame;
    info.type = i.compressed ? "sensor_msgs/CompressedImage" : "sensor_msgs/Image";
    info.camera = true;
    info.real_numbers = i.floats;
  }
  return s;
}

std::vector<std::string> lackNothing(const std::vector<std::string>& topics) {
  return std::vector<std::string>(topics.size());
}
std::vector<std::string> lackAll(const std::vector<std::string>& topics) {
  return std::vector<std::string>(topics.size(), "nothing is known");
}

std::vector<std::string> takenOf(std::initializer_list<Images> all,
                                 const Lacks& lacks = lackNothing, bool all_of_a_kind = false,
                                 const std::vector<std::string>& named = {}) {
  const Survey s = surveyOf(all);
  std::vector<std::string> out;
  for (const TopicInfo* t : chooseCameras(s, named, lacks, all_of_a_kind).taken)
    out.push_back(t->topic);
  return out;
}

using Topics = std::vector<std::string>;

TEST(ChooseCameras, LeftComesBeforeRightAndNumbersAreCounted) {
  EXPECT_EQ(takenOf({{"/stereo/right/image_raw", "r"}, {"/stereo/left/image_raw", "l"}}),
            (Topics{"/stereo/left/image_raw", "/stereo/right/image_raw"}));
  EXPECT_EQ(takenOf({{"/cam10/image_raw", ""}, {"/cam2/image_raw", ""}, {"/cam1/image_raw", ""}}),
            (Topics{"/cam1/image_raw", "/cam2/image_raw", "/cam10/image_raw"}));
  EXPECT_EQ(takenOf({{"/cam0/image_raw", "a"}, {"/cam1/image_raw", "b"}, {"/cam2/image_raw", "c"}}),
            (Topics{"/cam0/image_raw", "/cam1/image_raw", "/cam2/image_raw"}));
}

TEST(ChooseCameras, ThePairOfADepthCameraComesBeforeItsColours) {
  EXPECT_EQ(takenOf({{"/d455/aligned_depth_to_color/image_raw", "color"},
                     {"/d455/color/image_raw", "color"},
                     {"/d455/depth/image_rect_raw", "depth"},
                     {"/d455/infra1/image_rect_raw", "infra1"},
                     {"/d455/infra2/image_rect_raw", "infra2"}}),
            (Topics{"/d455/infra1/image_rect_raw", "/d455/infra2/image_rect_raw",
                    "/d455/color/image_raw"}));
}

TEST(ChooseCameras, WhatTheCalibrationNamesComesFirst) {
  const std::initializer_list<Images> all = {{"/d455/color/image_raw", "color"},
                                             {"/d455/infra1/image_rect_raw", "infra1"},
                                             {"/d455/infra2/image_rect_raw", "infra2"}};
  EXPECT_EQ(takenOf(all, lackNothing, false, {"/d455/color/image_raw"}),
            (Topics{"/d455/color/image_raw", "/d455/infra1/image_rect_raw",
                    "/d455/infra2/image_rect_raw"}));
  EXPECT_EQ(takenOf(all, lackAll, false, {"/d455/infra2/image_rect_raw/compressed", "/x"}),
            Topics{"/d455/infra2/image_rect_raw"});
}

TEST(ChooseCameras, TheSameImagesInAnotherFormAreNoSecondCamera) {
  EXPECT_EQ(takenOf({{"/cam0/image_raw", "a"},
                     {"/cam0/image_raw/compressed", "a", true},
                     {"/cam0/image_rect", "a"},
                     {"/cam0_rect/image", ""},
                     {"/cam1/image_raw/compressed", "b", true}}),
            (Topics{"/cam0/image_raw", "/cam1/image_raw/compressed"}));
  // ZED: /rgb is the left camera; an image with what was found drawn in has its frame as well.
  EXPECT_EQ(takenOf({{"/zed/left/image_rect_color", "left"},
                     {"/zed/left_raw/image_raw_color", "left"},
                     {"/zed/rgb/image_rect_color", "left"},
                     {"/zed/right/image_rect_color", "right"},
                     {"/tracker/debug", "left"},
                     {"/thermal/image", "thermal", false, true}}),
            (Topics{"/zed/left/image_rect_color", "/zed/right/image_rect_color"}));
  // Drivers that write one frame to both images of a pair.
  EXPECT_EQ(takenOf({{"/left/image_raw", "stereo"}, {"/right/image_raw", "stereo"}}),
            (Topics{"/left/image_raw", "/right/image_raw"}));
}

TEST(ChooseCameras, WhatLacksItsCalibrationIsNoFurtherCamera) {
  const std::initializer_list<Images> all = {
      {"/cam0/image_raw", "a"}, {"/cam1/image_raw", "b"}, {"/front/image", "c"}};
  EXPECT_EQ(takenOf(all, lackAll), Topics{"/cam0/image_raw"});
  EXPECT_EQ(takenOf(all, lackAll, true), (Topics{"/cam0/image_raw", "/cam1/image_raw"}));
  const Survey s = surveyOf(all);
  EXPECT_EQ(chooseCameras(s, {}, lackAll, false).left_out.at("/cam1/image_raw"),
            "nothing is known");
  EXPECT_TRUE(takenOf({{"/depth/image", "d"}}).empty());
}

class TwoCameras : public Recording {
 protected:
  void write(bool info, bool place) {
    test::Ros1Writer bag(path());
    const auto image = [&](const char* topic, const char* frame, TimeNs t, std::uint8_t grey) {
      test::writeImage(bag, topic, t, t, 32, 24, "mono8", 32,
                       std::vector<std::uint8_t>(32 * 24, grey), false, frame);
    };
    for (int i = 0; i < 3; ++i) {
      const TimeNs t = kStart + i * 50 * kMs;
      test::writeImu(bag, "/imu", t, t, {0, 0, 0}, {0, 0, 9.81});
      image("/right/image_raw", "r", t, 200);
      image("/left/image_raw", "l", t, 100);
      image("/left/image_rect", "l", t, 50);
      if (i > 0) continue;
      if (info) {
        for (const double f : {30.0, 31.0}) {
          test::writeCameraInfo(bag, f == 30 ? "/left/camera_info" : "/right/camera_info", t, 32,
                                24, "plumb_bob", {0, 0, 0, 0, 0}, f, f, 16, 12);
        }
      }
      if (!place) continue;
      test::writeStatic(bag, t, {0, 0.05, 0}, {0, 0, 0, 1}, "l");
      test::writeStatic(bag, t, {0, -0.06, 0}, {0, 0, 0, 1}, "r");
    }
  }
};

TEST_F(TwoCameras, ComeByThemselvesWithWhatTheRecordingSaysOfEach) {
  write(true, true);
  const auto images = only<ImageReading>(readAll());
  ASSERT_EQ(images.size(), 6u);
  for (const ImageReading& i : images) {
    EXPECT_EQ(i.pixels.at<std::uint8_t>(0, 0), i.camera == 0 ? 100 : 200);
  }
  ASSERT_EQ(recording->cameras().size(), 2u);
  EXPECT_EQ(recording->cameras()[0].intrinsics.fx, 30);
  EXPECT_EQ(recording->cameras()[1].intrinsics.fx, 31);
  EXPECT_EQ(recording->cameras()[0].T_B_C.p, Vec3(0, 0.05, 0));
  EXPECT_EQ(recording->cameras()[1].T_B_C.p, Vec3(0, -0.06, 0));
  EXPECT_TRUE(noted("/right/image_raw (sensor_msgs/Image) taken as camera, CAM1"));
  EXPECT_TRUE(
      noted("/left/image_rect (sensor_msgs/Image) left out: by its name or frame it is "
            "the camera of /left/image_raw once more"));
}

TEST_F(TwoCameras, OneWithoutAPlaceStaysOutAndThatIsSaid) {
  write(true, false);
  EXPECT_EQ(only<ImageReading>(readAll()).size(), 3u);
  EXPECT_EQ(recording->cameras().size(), 1u);
  EXPECT_TRUE(
      noted("/right/image_raw (sensor_msgs/Image) left out: a further camera, of which the "
            "place on the IMU is not known"));
  EXPECT_EQ(
      only<ImageReading>(readAll("imu=/imu camera=/left/image_raw camera=/right/image_raw")).size(),
      6u);
}

TEST_F(TwoCameras, OfACamchainInAnyOrder) {
  write(false, false);
  const auto block = [](const char* topic, double f) {
    return "  camera_model: pinhole\n  distortion_model: radtan\n"
           "  distortion_coeffs: [0, 0, 0, 0]\n  resolution: [32, 24]\n  rostopic: " +
           std::string(topic) + "\n  intrinsics: [" + std::to_string(f) + ", 30, 16, 12]\n";
  };
  const std::string first = "  T_cam_imu: [[1,0,0,-0.5],[0,1,0,0],[0,0,1,0],[0,0,0,1]]\n";
  const std::string second = "  T_cn_cnm1: [[1,0,0,-0.11],[0,1,0,0],[0,0,1,0],[0,0,0,1]]\n";
  const std::string file = (folder_ / "camchain.yaml").string();
  options.calibration = file;
  // The chain may begin at the right camera: topics tell which is which.
  test::writeText(file, "cam0:\n" + first + block("/right/image_raw", 31) + "cam1:\n" + second +
                            block("/left/image_raw/compressed", 30));
  EXPECT_EQ(only<ImageReading>(readAll()).size(), 6u);
  ASSERT_EQ(recording->cameras().size(), 2u);
  EXPECT_EQ(recording->cameras()[0].topic, "/left/image_raw");
  EXPECT_EQ(recording->cameras()[0].intrinsics.fx, 30);
  EXPECT_NEAR((recording->cameras()[0].T_B_C.p - Vec3(0.61, 0, 0)).norm(), 0, 1e-12);
  EXPECT_NEAR((recording->cameras()[1].T_B_C.p - Vec3(0.5, 0, 0)).norm(), 0, 1e-12);
  // Topics that are not in the recording say nothing: then the order does.
  test::writeText(file, "cam0:\n" + first + block("/a", 30) + "cam1:\n" + second + block("/b", 31));
  EXPECT_EQ(only<ImageReading>(readAll()).size(), 6u);
  EXPECT_EQ(recording->cameras()[1].intrinsics.fx, 31);
  // One that knows the left camera only says nothing of the right one.
  test::writeText(file, "cam0:\n" + first + block("/left/image_raw", 30));
  EXPECT_EQ(only<ImageReading>(readAll()).size(), 3u);
  EXPECT_TRUE(
      noted("/right/image_raw (sensor_msgs/Image) left out: a further camera, of which "
            "neither intrinsics nor the place on the IMU are known"));
}

}  // namespace
}  // namespace vir::bag
