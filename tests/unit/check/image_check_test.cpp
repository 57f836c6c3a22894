#include "vir/check/image_check.h"

#include <gtest/gtest.h>

#include "found.h"

namespace vir::check {
namespace {

/// 20 images of a chequered place, each a little different.
std::vector<Finding> findingsOf(double gain, double offset, int type = CV_8UC1) {
  ImageCheck check("CAM0");
  for (int i = 0; i < 20; ++i) {
    cv::Mat m(48, 64, CV_8UC1);
    for (int y = 0; y < m.rows; ++y) {
      for (int x = 0; x < m.cols; ++x) {
        const double v = ((x + i) / 8 + y / 8) % 2 == 0 ? 200 : 60;
        m.at<std::uint8_t>(y, x) = cv::saturate_cast<std::uint8_t>(gain * v + offset);
      }
    }
    cv::Mat other;
    m.convertTo(other, type);
    check.add(other);
  }
  return check.findings(64, 48);
}

TEST(ImageCheck, NamesWhatIsWrongWithTheLight) {
  EXPECT_EQ(seriousKinds(findingsOf(1, 0)), Kinds{});
  EXPECT_EQ(seriousKinds(findingsOf(0.1, 0)), Kinds{"low_contrast"});
  EXPECT_EQ(seriousKinds(findingsOf(0.02, 28)), Kinds{"blank"});
  EXPECT_EQ(seriousKinds(findingsOf(0.15, 0)), Kinds{"dark"});
  EXPECT_EQ(seriousKinds(findingsOf(1, 0, CV_16UC1)), Kinds{"unreadable"});
}

TEST(ImageCheck, NamesAnotherSize) {
  ImageCheck check("CAM0");
  cv::Mat m(48, 64, CV_8UC1, cv::Scalar(100));
  m.colRange(0, 32).setTo(200);
  check.add(m);
  EXPECT_EQ(seriousKinds(check.findings(64, 48)), Kinds{});
  EXPECT_EQ(seriousKinds(check.findings(752, 480)), Kinds{"image_size"});
}

}  // namespace
}  // namespace vir::check
