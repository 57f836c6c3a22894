/// Encodings of images beyond 8 bits and beyond one plane.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <opencv2/core.hpp>

#include "recording_fixture.h"

namespace vir::bag {
namespace {

using Pixels = std::vector<std::uint8_t>;

class Encodings : public Recording {
 protected:
  /// What comes of one image, named as the camera or found.
  cv::Mat one(const std::string& encoding, std::uint32_t width, std::uint32_t height,
              std::uint32_t step, const Pixels& pixels, bool big = false) {
    {
      test::Ros1Writer bag(path());
      test::writeImage(bag, "/cam/image_raw", kStart, kStart, width, height, encoding, step, pixels,
                       big);
    }
    options.need_calibration = false;
    const auto images = only<ImageReading>(readAll("camera=/cam/image_raw"));
    return images.empty() ? cv::Mat() : images.front().pixels;
  }
  std::vector<int> row(const cv::Mat& m, int y = 0) {
    std::vector<int> out;
    EXPECT_EQ(m.type(), CV_8UC1);
    for (int x = 0; x < m.cols; ++x) out.push_back(m.at<std::uint8_t>(y, x));
    return out;
  }
};

using Row = std::vector<int>;

TEST_F(Encodings, TenAndTwelveBitsInWordsOrPacked) {
  // 0, half, all: 0x000 0x200 0x3FF 0x001 of 10 bits, 0x000 0x800 0xFFF 0x010 of 12.
  options.levels_16_bit = {0, 1020};
  EXPECT_EQ(row(one("mono10", 4, 1, 8, {0, 0, 0, 2, 0xFF, 3, 4, 0})), (Row{0, 128, 255, 1}));
  EXPECT_EQ(row(one("mono10", 4, 1, 8, {0, 0, 2, 0, 3, 0xFF, 0, 4}, true)), (Row{0, 128, 255, 1}));
  // Lowest bit first: 0 | 0x200 << 10 | 0x3FF << 20 | 4 << 30, in five bytes.
  EXPECT_EQ(row(one("mono10p", 4, 1, 5, {0x00, 0x00, 0xF8, 0x3F, 0x01})), (Row{0, 128, 255, 1}));
  // High bytes outside, low bits in the middle.
  EXPECT_EQ(row(one("Mono10Packed", 4, 1, 6, {0x00, 0x00, 0x80, 0xFF, 0x03, 0x01})),
            (Row{0, 128, 255, 1}));
  options.levels_16_bit = {0, 4080};
  EXPECT_EQ(row(one("mono12", 4, 1, 8, {0, 0, 0, 8, 0xFF, 0xF, 16, 0})), (Row{0, 128, 255, 1}));
  EXPECT_EQ(row(one("mono12p", 4, 1, 6, {0x00, 0x00, 0x80, 0xFF, 0x0F, 0x01})),
            (Row{0, 128, 255, 1}));
  EXPECT_EQ(row(one("mono12packed", 4, 1, 6, {0x00, 0x00, 0x80, 0xFF, 0x0F, 0x01})),
            (Row{0, 128, 255, 1}));
  EXPECT_EQ(row(one("mono12p", 3, 1, 5, {0x00, 0x00, 0x80, 0xFF, 0x0F})), (Row{0, 128, 255}));
  EXPECT_TRUE(one("mono12p", 3, 1, 5, {0, 0, 0, 0}).empty());
  EXPECT_TRUE(one("mono12", 4, 1, 6, Pixels(6)).empty());
  EXPECT_NE(log.first("undecodable_CAM0").find("packed"), std::string::npos);
}

TEST_F(Encodings, OfPlanesTheLuminanceIsTaken) {
  for (const char* name : {"nv12", "NV21", "i420", "yuv420", "yv12"}) {
    EXPECT_EQ(row(one(name, 2, 2, 2, {1, 2, 3, 4, 128, 128}), 1), (Row{3, 4})) << name;
    EXPECT_TRUE(one(name, 2, 2, 2, {1, 2, 3, 4, 128}).empty()) << name;
  }
  EXPECT_EQ(row(one("nv24", 2, 1, 2, {1, 2, 9, 9, 9, 9})), (Row{1, 2}));
}

TEST_F(Encodings, EightBitsUnderOtherNames) {
  EXPECT_EQ(row(one("8UC1", 2, 1, 2, {5, 6})), (Row{5, 6}));
  EXPECT_EQ(one("8UC3", 1, 1, 3, {1, 2, 3}).at<cv::Vec3b>(0, 0), cv::Vec3b(1, 2, 3));
  EXPECT_EQ(one("8UC4", 1, 1, 4, {1, 2, 3, 9}).at<cv::Vec3b>(0, 0), cv::Vec3b(1, 2, 3));
}

TEST_F(Encodings, BayerOfMoreBitsHasItsColours) {
  options.levels_16_bit = {0, 4080};
  for (const char* name : {"bayer_rggb12", "bayer_rggb16", "BayerRG12"}) {
    Pixels pixels;
    for (int y = 0; y < 8; ++y) {
      for (int x = 0; x < 8; ++x) {
        const int v = 16 * (y % 2 == 0 && x % 2 == 0 ? 200 : y % 2 == 1 && x % 2 == 1 ? 50 : 100);
        pixels.push_back(static_cast<std::uint8_t>(v & 255));
        pixels.push_back(static_cast<std::uint8_t>(v >> 8));
      }
    }
    EXPECT_EQ(one(name, 8, 8, 16, pixels).at<cv::Vec3b>(4, 4), cv::Vec3b(50, 100, 200)) << name;
  }
}

Pixels floats(const std::vector<float>& values) {
  Pixels out(values.size() * sizeof(float));
  std::memcpy(out.data(), values.data(), out.size());
  return out;
}

TEST_F(Encodings, FloatsAreStretchedTheSameAllThrough) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  {
    test::Ros1Writer bag(path());
    std::vector<float> kelvin;
    for (int i = 0; i < 64 * 48; ++i)
      kelvin.push_back(290.0f + 10.0f * static_cast<float>(i % 101) / 100);
    for (int i = 0; i < 6; ++i) {
      if (i == 5) kelvin.assign(kelvin.size(), 295.0f);
      if (i == 5) kelvin[0] = nan, kelvin[1] = inf, kelvin[2] = -inf, kelvin[3] = 1e6f;
      test::writeImage(bag, "/thermal", kStart + i * kMs, kStart + i * kMs, 64, 48, "32FC1", 256,
                       floats(kelvin));
    }
  }
  options.need_calibration = false;
  const auto images = only<ImageReading>(readAll());
  ASSERT_EQ(images.size(), 6u);
  double low = 0, high = 0;
  cv::minMaxLoc(images[0].pixels, &low, &high);
  EXPECT_GT(high - low, 200);
  EXPECT_EQ(row(images[5].pixels)[0], 0);
  EXPECT_EQ(row(images[5].pixels)[1], 255);
  EXPECT_EQ(row(images[5].pixels)[2], 0);
  EXPECT_EQ(row(images[5].pixels)[3], 255);
  EXPECT_NEAR(row(images[5].pixels)[4], 127.5, 8);
  EXPECT_TRUE(noted("float images stretched"));
}

TEST_F(Encodings, DepthIsToldAndNotTaken) {
  {
    test::Ros1Writer bag(path());
    for (int i = 0; i < 3; ++i) {
      const TimeNs t = kStart + i * kMs;
      test::writeImage(bag, "/camera/aligned_depth/image_raw", t, t, 2, 1, "32FC1", 8,
                       floats({1, 2}));
      test::writeImage(bag, "/a", t, t, 2, 1, "32FC1", 8, floats({1, 2}));
      test::writeImage(bag, "/color", t, t, 2, 1, "mono8", 2, {1, 2});
    }
  }
  options.need_calibration = false;
  readAll();
  EXPECT_TRUE(noted("/color (sensor_msgs/Image) taken as camera"));
  EXPECT_TRUE(noted("/camera/aligned_depth/image_raw (sensor_msgs/Image) left out: no picture"));
  EXPECT_TRUE(noted("/a (sensor_msgs/Image) left out"));
  readAll("camera=/camera/aligned_depth/image_raw");
  EXPECT_TRUE(noted("its name says that it is no picture"));
}

TEST_F(Encodings, WhatIsNotKnownIsNamedWithoutAWish) {
  {
    test::Ros1Writer bag(path());
    test::writeImage(bag, "/cam", kStart, kStart, 2, 1, "jpegxl", 2, {1, 2});
    test::writeImage(bag, "/other", kStart, kStart, 2, 1, "mono8", 2, {1, 2});
  }
  options.need_calibration = false;
  readAll();
  EXPECT_TRUE(noted("/cam (sensor_msgs/Image) left out: image encoding 'jpegxl' cannot be read"));
}

}  // namespace
}  // namespace vir::bag
