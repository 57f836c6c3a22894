/// The class for programs of one's own: what it takes, tells and refuses.
#include "vir/estimator/vio.h"

#include <gtest/gtest.h>

#include "estimator_driver.h"

namespace vir {
namespace {

using vir_test::kMs;

constexpr TimeNs kStart = 1400000000000000000;

Calibration calibration() {
  Calibration c;
  c.T_B_C.p = Vec3(0.01, 0, 0);  // the identity would say that nobody knows it
  c.camera.width = vir_test::kWidth;
  c.camera.height = vir_test::kHeight;
  c.camera.fx = c.camera.fy = 250;
  c.camera.cx = vir_test::kWidth / 2.0;
  c.camera.cy = vir_test::kHeight / 2.0;
  return c;
}

/// 2 s of standing, noiseless, to `vio`; the pixels in rows of `stride` bytes.
void stand(Vio* vio, std::size_t stride) {
  const cv::Mat texture = vir_test::texture(1);
  std::vector<std::uint8_t> pixels(stride * vir_test::kHeight, 255);
  for (int y = 0; y < texture.rows; ++y) {
    std::copy_n(texture.ptr<std::uint8_t>(y), texture.cols, &pixels[stride * std::size_t(y)]);
  }
  for (int k = 0; k <= 400; ++k) {
    const TimeNs t = kStart + 5 * k * kMs;
    vio->add(ImuSample{t, Vec3::Zero(), Vec3(0, 0, 9.81)});
    if (k % 10 == 0) vio->add(Image{t, texture.cols, texture.rows, pixels.data(), stride});
    if (k % 20 == 0) vio->add(Range{t, 3, 2.5 + 0.001 * (k % 7), 0.1, Vec3::Zero()});
  }
  vio->finish();
}

TEST(Vio, TellsAStatePerImageAndWhatBecameOfEachRange) {
  Vio vio(calibration());
  std::vector<StateEstimate> states;
  std::vector<RangeRecord> ranges;
  vio.onState([&](const StateEstimate& s) { states.push_back(s); });
  vio.onRange([&](const RangeRecord& r) { ranges.push_back(r); });
  stand(&vio, vir_test::kWidth);
  ASSERT_EQ(states.size(), 41u);
  for (std::size_t k = 0; k < states.size(); ++k) {
    EXPECT_EQ(states[k].t_image, kStart + static_cast<TimeNs>(k) * 50 * kMs);
  }
  EXPECT_TRUE(states.back().valid);
  EXPECT_EQ(states.back().health, Health::standing);
  EXPECT_LT(states.back().state.T_W_B.p.norm(), 0.01);
  EXPECT_EQ(ranges.size(), 21u);
  ASSERT_EQ(vio.anchors().size(), 1u);
  EXPECT_EQ(vio.anchors()[0].id, 3u);
  EXPECT_FALSE(vio.keyframes().empty());
  EXPECT_EQ(vio.calibration().camera.fx, 250);
}

TEST(Vio, RowsMayHaveGapsBetweenThem) {
  std::vector<double> ends;
  for (const std::size_t stride : {std::size_t(vir_test::kWidth), std::size_t(384)}) {
    Vio vio(calibration());
    Vec3 last = Vec3::Ones();
    vio.onState([&](const StateEstimate& s) { last = s.state.T_W_B.p; });
    stand(&vio, stride);
    ends.push_back(last.x());
  }
  EXPECT_EQ(ends[0], ends[1]) << "the same bytes in, the same out";
}

TEST(Vio, RefusesWhatCannotBe) {
  Calibration none = calibration();
  none.camera.fx = 0;
  EXPECT_THROW(Vio{none}, std::invalid_argument);
  Vio vio(calibration());
  const std::vector<std::uint8_t> pixels(100, 0);
  EXPECT_THROW(vio.add(Image{kStart, 10, 10, pixels.data(), 0}), std::invalid_argument);
  EXPECT_THROW(vio.add(Image{kStart, vir_test::kWidth, vir_test::kHeight, nullptr, 0}),
               std::invalid_argument);
}

}  // namespace
}  // namespace vir
