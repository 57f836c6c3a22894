#include "patch.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <limits>

#include "synthetic_view.h"

namespace vir::vision {
namespace {

/// A texture and its view through x1 = A (x0 - centre) + centre + shift.
struct Views {
  cv::Mat before, after;
  Vec2 centre{100, 100};

  Views(const Eigen::Matrix2d& A, const Vec2& shift, double gain, double offset) {
    before = cv::Mat(200, 200, CV_8UC1);
    after = before.clone();
    const Eigen::Matrix2d inverse = A.inverse();
    for (int y = 0; y < 200; ++y) {
      for (int x = 0; x < 200; ++x) {
        before.at<uchar>(y, x) = cv::saturate_cast<uchar>(grey(Vec2(x, y)));
        const Vec2 source = inverse * (Vec2(x, y) - centre - shift) + centre;
        after.at<uchar>(y, x) = cv::saturate_cast<uchar>(gain * grey(source) + offset);
      }
    }
  }
  static double grey(const Vec2& p) {
    return 110 + 35 * std::sin(0.55 * p.x() + 0.2 * p.y()) + 30 * std::sin(0.6 * p.y() - 0.1) +
           15 * std::sin(0.13 * p.x() - 0.31 * p.y());
  }
};

TEST(Patch, FindsSubPixelShiftAndWarpUnderGainAndOffset) {
  Eigen::Matrix2d A;
  A << 1.04, 0.05, -0.03, 0.97;
  for (const Vec2& shift : {Vec2(0, 0), Vec2(0.37, -0.81), Vec2(-1.6, 1.2)}) {
    for (const double gain : {1.0, 0.5, 1.3}) {
      const Views views(A, shift, gain, gain < 1 ? 30.0 : -20.0);
      const Vec2 feature(100.3, 99.6);
      Patch patch;
      ASSERT_TRUE(patch.take(views.before, feature, 7));
      PatchWarp warp = patch.origin();
      EXPECT_LT((patch.feature(warp) - feature).norm(), 1e-12);
      ASSERT_TRUE(patch.align(views.after, {20, 4.0, 0.8}, &warp));
      const Vec2 truth = A * (feature - views.centre) + views.centre + shift;
      EXPECT_LT((patch.feature(warp) - truth).norm(), 0.03) << shift.transpose() << " " << gain;
      EXPECT_LT((warp.A - A).norm(), 0.02) << warp.A;
    }
  }
}

TEST(Patch, RefusesWhatLooksDifferent) {
  const Views views(Eigen::Matrix2d::Identity(), Vec2::Zero(), 1.0, 0.0);
  Patch patch;
  ASSERT_TRUE(patch.take(views.before, Vec2(100, 100), 7));
  cv::Mat other = views.before.clone();
  cv::RNG random(5);
  random.fill(other, cv::RNG::UNIFORM, 0, 255);
  PatchWarp warp = patch.origin();
  EXPECT_FALSE(patch.align(other, {20, 4.0, 0.8}, &warp));
  warp = patch.origin();
  EXPECT_FALSE(patch.align(cv::Mat::zeros(200, 200, CV_8UC1), {20, 4.0, 0.8}, &warp));
}

TEST(Patch, RefusesWhatHasNoTextureOrDoesNotFit) {
  const Views views(Eigen::Matrix2d::Identity(), Vec2::Zero(), 1.0, 0.0);
  Patch patch;
  EXPECT_FALSE(patch.take(cv::Mat(50, 50, CV_8UC1, cv::Scalar(90)), Vec2(25, 25), 7));
  EXPECT_TRUE(patch.empty());
  for (const Vec2& p : {Vec2(7, 100), Vec2(100, 7), Vec2(192, 100), Vec2(100, 192), Vec2(-50, 9)}) {
    EXPECT_FALSE(patch.take(views.before, p, 7)) << p.transpose();
  }
  EXPECT_TRUE(patch.take(views.before, Vec2(8, 191), 7));
  PatchWarp warp;
  for (const double x : {-1.0, 6.9, 192.5, 1e9, -1e300, std::numeric_limits<double>::quiet_NaN()}) {
    warp.A.setIdentity();
    warp.c = Vec2(x, 100);
    EXPECT_FALSE(patch.align(views.before, {20, 4.0, 0.8}, &warp)) << x;
  }
}

}  // namespace
}  // namespace vir::vision
