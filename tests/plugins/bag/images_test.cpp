/// Encodings of images, contrast, CameraInfo.
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "bag_recording.h"
#include "vir_test_bag_writer.h"
#include "vir_test_temp_folder.h"
#include "whole_png.h"

namespace vir::bag {
namespace {

constexpr TimeNs kMs = 1'000'000;
const TimeNs kStart = 1'600'000'000LL * 1'000 * kMs;
using Pixels = std::vector<std::uint8_t>;

class Images : public testing::Test {
 protected:
  /// What comes of one image.
  cv::Mat one(const std::string& encoding, std::uint32_t width, std::uint32_t height,
              std::uint32_t step, const Pixels& pixels, bool big = false) {
    const std::string path = (folder_ / (encoding + ".mcap")).string();
    {
      test::McapWriter bag(path);
      test::writeImage(bag, "/cam/image_raw", kStart, kStart, width, height, encoding, step, pixels,
                       big);
    }
    BagOptions o;
    o.source = path;
    o.topics = "camera=/cam/image_raw";
    o.need_calibration = false;
    o.levels_16_bit = levels;
    log = {};
    BagRecording r(o, &log);
    Reading reading;
    return r.next(&reading) ? std::get<ImageReading>(reading.what).pixels : cv::Mat();
  }

  test::TempFolder folder_;
  ProblemLog log;
  std::vector<double> levels;
};

TEST_F(Images, ColoursEndUpAsBlueGreenRed) {
  const cv::Vec3b expected(3, 2, 1);
  EXPECT_EQ(one("rgb8", 1, 1, 3, {1, 2, 3}).at<cv::Vec3b>(0, 0), expected);
  EXPECT_EQ(one("bgr8", 1, 1, 3, {3, 2, 1}).at<cv::Vec3b>(0, 0), expected);
  EXPECT_EQ(one("rgba8", 1, 1, 4, {1, 2, 3, 9}).at<cv::Vec3b>(0, 0), expected);
  EXPECT_EQ(one("bgra8", 1, 1, 4, {3, 2, 1, 9}).at<cv::Vec3b>(0, 0), expected);
}

TEST_F(Images, RowsMayBeLongerThanTheImage) {
  const cv::Mat m = one("mono8", 2, 2, 5, {1, 2, 99, 99, 99, 3, 4, 99, 99, 99});
  ASSERT_EQ(m.size(), cv::Size(2, 2));
  EXPECT_EQ(m.at<std::uint8_t>(1, 0), 3);
  EXPECT_EQ(m.at<std::uint8_t>(1, 1), 4);
}

/// Each pattern says the colour of its first pixel, then along the row; below it the second row.
TEST_F(Images, BayerPatternsAreNotMixedUp) {
  const struct {
    const char* name;
    char colours[4];
  } patterns[] = {{"bayer_rggb8", {'r', 'g', 'g', 'b'}},
                  {"bayer_bggr8", {'b', 'g', 'g', 'r'}},
                  {"bayer_gbrg8", {'g', 'b', 'r', 'g'}},
                  {"bayer_grbg8", {'g', 'r', 'b', 'g'}}};
  for (const auto& p : patterns) {
    Pixels pixels(8 * 8);
    for (std::size_t y = 0; y < 8; ++y) {
      for (std::size_t x = 0; x < 8; ++x) {
        const char c = p.colours[(y % 2) * 2 + x % 2];
        pixels[y * 8 + x] = c == 'r' ? 200 : c == 'g' ? 100 : 50;
      }
    }
    const cv::Vec3b v = one(p.name, 8, 8, 8, pixels).at<cv::Vec3b>(4, 4);
    EXPECT_EQ(v, cv::Vec3b(50, 100, 200)) << p.name;
  }
}

TEST_F(Images, Yuv422InBothOrders) {
  // Gray: both colour differences in the middle.
  const cv::Mat uyvy = one("yuv422", 2, 1, 4, {128, 100, 128, 200});
  const cv::Mat yuyv = one("yuv422_yuy2", 2, 1, 4, {100, 128, 200, 128});
  ASSERT_EQ(uyvy.channels(), 3);
  EXPECT_EQ(uyvy.at<cv::Vec3b>(0, 0), yuyv.at<cv::Vec3b>(0, 0));
  EXPECT_EQ(uyvy.at<cv::Vec3b>(0, 1), yuyv.at<cv::Vec3b>(0, 1));
  EXPECT_LT(uyvy.at<cv::Vec3b>(0, 0)[0], uyvy.at<cv::Vec3b>(0, 1)[0]);
}

TEST_F(Images, SixteenBitsByTheLevelsGivenInBothOrdersOfBytes) {
  levels = {1000, 2020};
  const Pixels little = {0xE8, 0x03, 0xE6, 0x05, 0xE4, 0x07, 0xFF, 0xFF};  // 1000 1510 2020 65535
  Pixels big = little;
  for (std::size_t i = 0; i < big.size(); i += 2) std::swap(big[i], big[i + 1]);
  for (const bool swapped : {false, true}) {
    const cv::Mat m = one("mono16", 4, 1, 8, swapped ? big : little, swapped);
    ASSERT_EQ(m.type(), CV_8UC1);
    EXPECT_EQ(m.at<std::uint8_t>(0, 0), 0);
    EXPECT_NEAR(m.at<std::uint8_t>(0, 1), 127.5, 0.6);
    EXPECT_EQ(m.at<std::uint8_t>(0, 2), 255);
    EXPECT_EQ(m.at<std::uint8_t>(0, 3), 255);
  }
}

/// 12-bit and thermal images use a small part of 16 bits: they must not come out blank, and the
/// same scene must look the same all through.
TEST_F(Images, DarkSixteenBitsAreStretchedTheSameAllThrough) {
  const std::string path = (folder_ / "t.mcap").string();
  {
    test::McapWriter bag(path);
    for (int i = 0; i < 30; ++i) {
      Pixels pixels;
      for (int k = 0; k < 64 * 48; ++k) {
        const int value = i == 29 ? 7000 : 7000 + k % 300;
        pixels.push_back(static_cast<std::uint8_t>(value & 255));
        pixels.push_back(static_cast<std::uint8_t>(value >> 8));
      }
      test::writeImage(bag, "/thermal/image_raw", kStart + i * 30 * kMs, kStart + i * 30 * kMs, 64,
                       48, "16UC1", 128, pixels);
    }
  }
  BagOptions o;
  o.source = path;
  o.need_calibration = false;
  BagRecording r(o, &log);
  std::vector<cv::Mat> all;
  for (Reading x; r.next(&x);) all.push_back(std::get<ImageReading>(x.what).pixels);
  ASSERT_EQ(all.size(), 30u);
  double low = 0, high = 0;
  cv::minMaxLoc(all[0], &low, &high);
  EXPECT_GT(high - low, 150);
  EXPECT_EQ(all[0].at<std::uint8_t>(0, 0), all[29].at<std::uint8_t>(0, 0));
  EXPECT_EQ(log.get("images_stretched_16_to_8_bit"), 30);
}

TEST_F(Images, WhatIsNoImageIsCounted) {
  EXPECT_TRUE(one("mono8", 4, 4, 4, Pixels(15)).empty());
  EXPECT_EQ(log.get("undecodable_CAM0"), 1);
  EXPECT_TRUE(one("mono8", 4, 4, 3, Pixels(16)).empty());
  EXPECT_TRUE(one("mono8", 0, 4, 4, Pixels(16)).empty());
  EXPECT_TRUE(one("mono8", 4'000'000'000u, 1, 4'000'000'000u, Pixels(16)).empty());
  EXPECT_TRUE(one("32SC2", 2, 2, 16, Pixels(32)).empty());
  EXPECT_NE(log.first("undecodable_CAM0").find("32SC2"), std::string::npos);
}

TEST_F(Images, CompressedOnesKeepTheirBytes) {
  const std::string path = (folder_ / "c.mcap").string();
  cv::Mat picture(20, 30, CV_8UC1);
  for (int i = 0; i < 600; ++i) picture.data[i] = static_cast<std::uint8_t>(i * 7);
  Pixels png, jpeg;
  cv::imencode(".png", picture, png);
  cv::imencode(".jpg", picture, jpeg);
  {
    test::McapWriter bag(path);
    const auto write = [&](const Pixels& bytes, int i) {
      test::WireBytes m = bag.message();
      m.header(kStart + i * kMs, "cam").text("mono8; compressed").raw(bytes.data(), bytes.size());
      bag.write("/cam/image_raw/compressed", "sensor_msgs/CompressedImage", m.bytes(),
                kStart + i * kMs);
    };
    write(png, 0);
    write(jpeg, 1);
    write(Pixels(jpeg.begin(), jpeg.begin() + 200), 2);  // cut
  }
  BagOptions o;
  o.source = path;
  o.need_calibration = false;
  BagRecording r(o, &log);
  Reading x;
  ASSERT_TRUE(r.next(&x));
  EXPECT_EQ(std::get<ImageReading>(x.what).file, png);
  EXPECT_STREQ(std::get<ImageReading>(x.what).extension, ".png");
  ASSERT_TRUE(r.next(&x));
  EXPECT_EQ(std::get<ImageReading>(x.what).file, jpeg);
  EXPECT_FALSE(r.next(&x));
  EXPECT_EQ(log.get("undecodable_CAM0"), 1);
}

TEST(WholePng, IsToldWithoutDecodingIt) {
  Pixels png;
  cv::imencode(".png", cv::Mat(20, 30, CV_8UC1, cv::Scalar(7)), png);
  const auto size = wholePlainPng(png.data(), png.size());
  ASSERT_TRUE(size.has_value());
  EXPECT_EQ(size->width, 30);
  EXPECT_EQ(size->height, 20);
  // Every byte matters.
  for (std::size_t i = 0; i < png.size(); ++i) {
    Pixels damaged = png;
    damaged[i] ^= 0x10;
    EXPECT_FALSE(wholePlainPng(damaged.data(), damaged.size()).has_value()) << i;
    EXPECT_FALSE(wholePlainPng(png.data(), i).has_value()) << i;
  }
  for (const int type : {CV_16UC1, CV_8UC4}) {
    cv::imencode(".png", cv::Mat(20, 30, type, cv::Scalar::all(7)), png);
    EXPECT_FALSE(wholePlainPng(png.data(), png.size()).has_value()) << type;
  }
  cv::imencode(".png", cv::Mat(20, 30, CV_8UC3, cv::Scalar(1, 2, 3)), png);
  EXPECT_TRUE(wholePlainPng(png.data(), png.size()).has_value());
}

CameraInfo infoOf(const std::string& model, const std::vector<double>& D) {
  CameraInfo c;
  c.width = 640, c.height = 480;
  c.model = model;
  c.D = D;
  c.K = {400, 0, 320, 0, 410, 240, 0, 0, 1};
  c.P = {380, 0, 315, 0, 0, 385, 238, 0, 0, 0, 1, 0};
  return c;
}

TEST(CameraInfoOf, ModelsOfRos) {
  CameraCalibration c;
  std::string why;
  ASSERT_TRUE(intrinsicsOf(infoOf("equidistant", {0.1, 0.2, 0.3, 0.4}), "/c", 640, 480, &c, &why));
  EXPECT_EQ(c.distortion, Distortion::equidistant);
  EXPECT_EQ(c.dist[3], 0.4);
  ASSERT_TRUE(intrinsicsOf(infoOf("plumb_bob", {0, 0, 0, 0, 0}), "/c", 640, 480, &c, &why));
  EXPECT_EQ(c.distortion, Distortion::none);
  const std::vector<double> rational{0.4, -2.5, 0.001, 0.0005, 1.4, 0.3, -2.3, 1.3};
  ASSERT_TRUE(intrinsicsOf(infoOf("rational_polynomial", rational), "/c", 640, 480, &c, &why));
  EXPECT_EQ(c.distortion, Distortion::rational);
  EXPECT_TRUE(std::equal(rational.begin(), rational.end(), c.dist.begin()));
  EXPECT_FALSE(intrinsicsOf(infoOf("strange", {1}), "/c", 640, 480, &c, &why));
  EXPECT_NE(why.find("strange"), std::string::npos);
  CameraInfo empty = infoOf("plumb_bob", {});
  empty.K.assign(9, 0);
  EXPECT_FALSE(intrinsicsOf(empty, "/c", 640, 480, &c, &why));
  EXPECT_NE(why.find("never calibrated"), std::string::npos);
}

TEST(CameraInfoOf, RectifiedImagesHaveTheProjectionAndNoDistortion) {
  CameraCalibration c;
  std::string why;
  ASSERT_TRUE(intrinsicsOf(infoOf("plumb_bob", {-0.3, 0.1, 0, 0, 0}), "/left/image_rect", 640, 480,
                           &c, &why));
  EXPECT_EQ(c.distortion, Distortion::none);
  EXPECT_EQ(c.fx, 380);
  EXPECT_EQ(c.cy, 238);
}

TEST(CameraInfoOf, HalfTheSizeHasHalfTheFocalLength) {
  CameraCalibration c;
  std::string why;
  ASSERT_TRUE(intrinsicsOf(infoOf("plumb_bob", {}), "/c", 320, 240, &c, &why));
  EXPECT_EQ(c.fx, 200);
  EXPECT_EQ(c.cx, 159.75);  // the middle of the first pixel is 0
  EXPECT_FALSE(intrinsicsOf(infoOf("plumb_bob", {}), "/c", 640, 400, &c, &why));
  EXPECT_NE(why.find("640x400"), std::string::npos);
}

}  // namespace
}  // namespace vir::bag
