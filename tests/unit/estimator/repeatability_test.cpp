#include <gtest/gtest.h>

#include <cstring>

#include "estimator_driver.h"

namespace vir::estimator {
namespace {

using vir_test::EstimatorDriver;
using vir_test::kMs;

enum class Threads { one, two };

/// 30 images of a picture that slides by, a part of it back and forth: the back end finds that
/// wrong.
void slideWithAnOutlier(unsigned seed, TimeNs start, EstimatorDriver* d) {
  cv::Mat wide;
  cv::hconcat(d->image, vir_test::texture(seed + 50), wide);
  const cv::Mat other = vir_test::texture(seed + 70);
  for (int k = 1; k <= 30; ++k) {
    const TimeNs t = start + 50 * k * kMs;
    d->imu(t - 50 * kMs, t);
    cv::Mat image = wide(cv::Rect(4 * k, 0, vir_test::kWidth, vir_test::kHeight)).clone();
    const int shift = 60 - 4 * (k % 8);
    other(cv::Rect(shift, 80, 150, 90)).copyTo(image(cv::Rect(90, 80, 150, 90)));
    d->estimator.addImage(t, image);
  }
}

/// All numbers of a run in a row, except CPU times.
std::vector<double> numbersOf(unsigned seed, bool pipelined = false,
                              Threads threads = Threads::one) {
  EstimatorConfig config;
  config.pipelined = pipelined;
  config.failure.max_blind_s = 0.5;
  EstimatorDriver d(seed, config);
  std::vector<StateEstimate> estimates;
  const auto collect = [&] {
    for (const StateEstimate& e : d.estimator.take()) estimates.push_back(e);
  };
  if (threads == Threads::two) d.estimator.workBehind(collect);
  TimeNs start = 1400000000000000000;
  // Stands, then sees something slide by for a while, then stands again.
  d.run(start, start + 1000 * kMs);
  slideWithAnOutlier(seed, start + 1000 * kMs, &d);
  d.run(start + 2500 * kMs, start + 3500 * kMs);
  // The IMU is silent for a second: the images go across.
  for (int k = 1; k <= 20; ++k) d.estimator.addImage(start + (3500 + 50 * k) * kMs, d.image);
  d.run(start + 4500 * kMs, start + 5500 * kMs);
  // And for five: a new segment, with images of the hole left out.
  start += 5000 * kMs;
  for (int k = 1; k <= 100; ++k) d.estimator.addImage(start + (500 + 50 * k) * kMs, d.image);
  d.run(start + 5500 * kMs, start + 7000 * kMs);
  // Light fails for so long that it is given up, in the middle of images.
  const cv::Mat light = d.image;
  d.image = cv::Mat(vir_test::kHeight, vir_test::kWidth, CV_8UC1, cv::Scalar(0));
  d.run(start + 7000 * kMs, start + 8000 * kMs);
  d.image = light;
  d.run(start + 8000 * kMs, start + 9500 * kMs);
  d.estimator.finish();
  collect();
  EXPECT_GE(d.estimator.resets(), 2);
  EXPECT_TRUE(estimates.back().valid) << healthText(estimates.back());
  std::vector<double> out;
  const auto add = [&](const State& s) {
    out.push_back(static_cast<double>(s.t));
    for (const Vec3& v : {s.T_W_B.p, s.v, s.bg, s.ba}) {
      for (int i = 0; i < 3; ++i) out.push_back(v[i]);
    }
    for (int i = 0; i < 4; ++i) out.push_back(s.T_W_B.q.coeffs()[i]);
  };
  for (const StateEstimate& e : estimates) {
    EXPECT_TRUE(vir_test::finite(e));
    add(e.state);
    for (double x : {double(e.valid), double(e.segment), double(e.keyframe),
                     double(static_cast<int>(e.health)), double(e.tracks), double(e.landmarks),
                     e.reprojection_rms}) {
      out.push_back(x);
    }
  }
  for (const State& s : d.estimator.keyframes()) add(s);
  for (const Landmark& l : d.estimator.landmarks()) {
    out.push_back(static_cast<double>(l.id));
    for (int i = 0; i < 3; ++i) out.push_back(l.p_W[i]);
  }
  return out;
}

bool sameBits(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

TEST(EstimatorRepeatability, TwoRunsGiveTheSameBits) {
  const std::vector<double> a = numbersOf(3), b = numbersOf(3);
  EXPECT_GT(a.size(), 1000u);
  EXPECT_TRUE(sameBits(a, b));
}

TEST(EstimatorRepeatability, TwoThreadsGiveTheBitsOfOneWithTheSameDelay) {
  const std::vector<double> one = numbersOf(3, true);
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(sameBits(one, numbersOf(3, true, Threads::two)));
  EXPECT_FALSE(sameBits(one, numbersOf(3)));
}

TEST(EstimatorRepeatability, TwoThreadsNeedTheDelay) {
  EstimatorDriver d(3);
  EXPECT_THROW(d.estimator.workBehind([] {}), std::logic_error);
}

TEST(EstimatorRepeatability, AnotherSeedGivesOtherNumbers) {
  EXPECT_NE(numbersOf(3), numbersOf(4));
}

}  // namespace
}  // namespace vir::estimator
