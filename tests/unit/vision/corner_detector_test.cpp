#include "vir/vision/corner_detector.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

namespace vir::vision {
namespace {

cv::Mat gradientOf(const cv::Mat& image) {
  cv::Mat gx, gy, both;
  cv::Scharr(image, gx, CV_16S, 1, 0);
  cv::Scharr(image, gy, CV_16S, 0, 1);
  cv::merge(std::vector<cv::Mat>{gx, gy}, both);
  return both;
}

/// White squares of 9 px, 40 px apart.
cv::Mat squares() {
  cv::Mat image(200, 240, CV_8UC1, cv::Scalar(50));
  for (int y = 20; y < 190; y += 40) {
    for (int x = 20; x < 230; x += 40) {
      cv::rectangle(image, cv::Rect(x, y, 9, 9), cv::Scalar(200), -1);
    }
  }
  cv::GaussianBlur(image, image, cv::Size(3, 3), 0);
  return image;
}

TEST(CornerDetector, FindsCornersAndKeepsTheDistance) {
  const cv::Mat image = squares();
  CornerDetector detector({30, 12, 20, 6});
  const auto found = detector.detect(gradientOf(image), {}, 1000);
  EXPECT_GE(found.size(), 28u);
  for (std::size_t i = 0; i < found.size(); ++i) {
    // Modulo the raster: a corner lies on the square's rim, 0 or 8 px from its first pixel.
    const float x = std::fmod(found[i].x - 20.0f + 40.0f, 40.0f);
    const float y = std::fmod(found[i].y - 20.0f + 40.0f, 40.0f);
    const auto off = [](float v) { return std::min(std::abs(v), std::abs(v - 8.0f)); };
    EXPECT_LT(off(x > 30 ? x - 40 : x), 3.0f) << found[i];
    EXPECT_LT(off(y > 30 ? y - 40 : y), 3.0f) << found[i];
    for (std::size_t j = 0; j < i; ++j) EXPECT_GE(cv::norm(found[i] - found[j]), 12.0);
  }
}

TEST(CornerDetector, LeavesRoomAroundWhatIsThere) {
  const cv::Mat gradient = gradientOf(squares());
  CornerDetector first({30, 12, 20, 6}), second({30, 12, 20, 6});
  const auto some = first.detect(gradient, {}, 10);
  EXPECT_EQ(some.size(), 10u);
  for (const cv::Point2f& p : second.detect(gradient, some, 1000)) {
    for (const cv::Point2f& q : some) EXPECT_GE(cv::norm(p - q), 12.0);
  }
  EXPECT_TRUE(second.detect(gradient, some, 0).empty());
  EXPECT_TRUE(second.detect(gradient, some, -3).empty());
}

TEST(CornerDetector, FindsNothingOnEdgesAndFlats) {
  cv::Mat image(200, 240, CV_8UC1, cv::Scalar(50));
  image.colRange(100, 240).setTo(200);
  CornerDetector detector({30, 12, 20, 6});
  EXPECT_TRUE(detector.detect(gradientOf(image), {}, 100).empty());
  // A cell that was empty rests, but not for ever.
  const cv::Mat gradient = gradientOf(squares());
  std::size_t found = 0;
  for (int i = 0; i < 8; ++i) found = std::max(found, detector.detect(gradient, {}, 100).size());
  EXPECT_GT(found, 20u);
}

}  // namespace
}  // namespace vir::vision
