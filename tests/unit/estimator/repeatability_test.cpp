#include <gtest/gtest.h>

#include <cstring>

#include "estimator_driver.h"

namespace vir {
namespace {

using vir_test::EstimatorDriver;
using vir_test::kMs;

/// All numbers of a run in a row, except CPU times.
std::vector<double> numbersOf(unsigned seed) {
  EstimatorDriver d(seed);
  const TimeNs start = 1400000000000000000;
  // Stands, then the picture slides over the image for a while, then stands again.
  d.run(start, start + 1000 * kMs);
  cv::Mat wide;
  cv::hconcat(d.image, vir_test::texture(seed + 50), wide);
  for (int k = 1; k <= 30; ++k) {
    const TimeNs t = start + (1000 + 50 * k) * kMs;
    d.imu(t - 50 * kMs, t);
    d.estimator.addImage(t, wide(cv::Rect(4 * k, 0, vir_test::kWidth, vir_test::kHeight)));
  }
  d.run(start + 2500 * kMs, start + 3500 * kMs);
  d.estimator.finish();
  std::vector<double> out;
  const auto add = [&](const NavState& s) {
    out.push_back(static_cast<double>(s.t));
    for (const Vec3& v : {s.T_W_B.p, s.v, s.bg, s.ba}) {
      for (int i = 0; i < 3; ++i) out.push_back(v[i]);
    }
    for (int i = 0; i < 4; ++i) out.push_back(s.T_W_B.q.coeffs()[i]);
  };
  for (const FrameEstimate& e : d.estimator.take()) {
    EXPECT_TRUE(vir_test::finite(e));
    add(e.state);
    for (double x : {double(e.valid), double(e.segment), double(e.keyframe), double(e.standing),
                     double(e.tracks), double(e.landmarks), e.reprojection_rms}) {
      out.push_back(x);
    }
  }
  for (const NavState& s : d.estimator.keyframes()) add(s);
  for (const WindowLandmark& l : d.estimator.landmarks()) {
    out.push_back(static_cast<double>(l.id));
    for (int i = 0; i < 3; ++i) out.push_back(l.p_W[i]);
  }
  return out;
}

TEST(EstimatorRepeatability, TwoRunsGiveTheSameBits) {
  const std::vector<double> a = numbersOf(3), b = numbersOf(3);
  ASSERT_EQ(a.size(), b.size());
  EXPECT_GT(a.size(), 1000u);
  EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size() * sizeof(double)), 0);
}

TEST(EstimatorRepeatability, AnotherSeedGivesOtherNumbers) {
  EXPECT_NE(numbersOf(3), numbersOf(4));
}

}  // namespace
}  // namespace vir
