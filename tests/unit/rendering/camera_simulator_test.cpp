/// The simulated camera does what it is asked for, and the same again.
#include "vir/rendering/camera_simulator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "made_scenes.h"

namespace {

using namespace vir;
using vir_test::calibration;
using vir_test::lookingAhead;

vir::rendering::CameraSimulationOptions perfect() {
  vir::rendering::CameraSimulationOptions o;
  o.noise_grey = o.shot_noise = o.vignetting = o.exposure_s = o.exposure_wander = 0;
  return o;
}

vir::rendering::CameraSimulator simulator(const vir::rendering::CameraSimulationOptions& o) {
  return vir::rendering::CameraSimulator(o, vir_test::twoCrates(),
                                         camera::makeCamera(calibration(Distortion::radtan)));
}

Pose still(double) { return lookingAhead(Vec3(0.2, 0, 0)); }
/// Turns to the right by 2 rad/s: 460 px/s.
Pose turning(double dt) { return lookingAhead(Vec3(0.2, 0, 0), Vec3(0, 2 * dt, 0)); }

vir::rendering::GrayImage taken(const vir::rendering::CameraSimulationOptions& o, double s = 1,
                                std::uint64_t number = 0,
                                const vir::rendering::CameraSimulator::PoseAt& pose = still) {
  vir::rendering::CameraSimulator camera = simulator(o);
  return camera.take(s, number, pose);
}

double mean(const vir::rendering::GrayImage& image) {
  double sum = 0;
  for (const std::uint8_t v : image.pixels) sum += v;
  return sum / static_cast<double>(image.pixels.size());
}

/// Mean square of the difference of neighbours along x or y.
double gradient(const vir::rendering::GrayImage& image, int dx, int dy) {
  double sum = 0;
  for (int y = 0; y + 1 < image.height; ++y) {
    for (int x = 0; x + 1 < image.width; ++x) {
      const auto at = static_cast<std::size_t>(y * image.width + x);
      const auto next = static_cast<std::size_t>((y + dy) * image.width + x + dx);
      sum += std::pow(image.pixels[next] - image.pixels[at], 2);
    }
  }
  return sum / static_cast<double>(image.pixels.size());
}

TEST(CameraSimulator, SameSeedSameBytes) {
  vir::rendering::CameraSimulationOptions o;
  o.exposure_s = 0.02;
  const vir::rendering::GrayImage a = taken(o, 1, 7, turning);
  EXPECT_EQ(a.pixels, taken(o, 1, 7, turning).pixels);
  EXPECT_NE(a.pixels, taken(o, 1, 8, turning).pixels);  // other noise
  // An image does not depend on those before it.
  vir::rendering::CameraSimulator camera = simulator(o);
  camera.take(0.5, 6, still);
  EXPECT_EQ(a.pixels, camera.take(1, 7, turning).pixels);
  o.seed = 2;
  EXPECT_NE(a.pixels, taken(o, 1, 7, turning).pixels);
}

TEST(CameraSimulator, HasTheNoiseAskedFor) {
  vir::rendering::CameraSimulationOptions o = perfect();
  o.noise_grey = 3;
  vir::rendering::CameraSimulator camera = simulator(o);
  const vir::rendering::GrayImage a = camera.take(1, 1, still), b = camera.take(1, 2, still);
  double sum = 0, square = 0;
  const auto n = static_cast<double>(a.pixels.size());
  for (std::size_t k = 0; k < a.pixels.size(); ++k) {
    const double d = a.pixels[k] - b.pixels[k];
    sum += d;
    square += d * d;
  }
  EXPECT_LT(std::abs(sum / n), 0.05);
  // Two images; rounding adds 1/12 to each variance.
  EXPECT_NEAR(std::sqrt(square / n), std::sqrt(2 * (9 + 1.0 / 12)), 0.05);
}

TEST(CameraSimulator, CornersAreDarker) {
  vir::rendering::CameraSimulationOptions o = perfect();
  const vir::rendering::GrayImage plain = taken(o);
  o.vignetting = 0.5;
  const vir::rendering::GrayImage dim = taken(o);
  const auto ratio = [&](int x, int y) {
    const auto at = static_cast<std::size_t>(y * plain.width + x);
    return (dim.pixels[at] + 0.5) / (plain.pixels[at] + 0.5);
  };
  EXPECT_NEAR(ratio(188, 120), 1, 0.02);
  EXPECT_NEAR(ratio(1, 1), 0.5, 0.03);
}

TEST(CameraSimulator, ExposureJumpsAndDarkPhases) {
  vir::rendering::CameraSimulationOptions o = perfect();
  o.exposure_jump = {2, 0.5, 4, 1.2};
  o.dark_s = {6, 7};
  const double before = mean(taken(o, 1));
  EXPECT_NEAR(mean(taken(o, 3)) / before, 0.5, 0.01);
  EXPECT_NEAR(mean(taken(o, 5)) / before, 1.2, 0.02);
  EXPECT_LT(mean(taken(o, 6.5)), 3);
  EXPECT_NEAR(mean(taken(o, 7)) / before, 1.2, 0.02);
}

TEST(CameraSimulator, BrightnessWandersButNotFar) {
  vir::rendering::CameraSimulationOptions o = perfect();
  o.exposure_wander = 0.1;
  vir::rendering::CameraSimulator camera = simulator(o);
  double sum = 0, square = 0;
  constexpr int kImages = 60;
  for (int k = 0; k < kImages; ++k) {
    const double v = std::log(mean(camera.take(1.7 * k, 0, still)));
    sum += v;
    square += v * v;
  }
  const double spread = std::sqrt(square / kImages - std::pow(sum / kImages, 2));
  EXPECT_GT(spread, 0.05);
  EXPECT_LT(spread, 0.15);
}

TEST(CameraSimulator, PoorTextureHasNothingToHoldOnTo) {
  vir::rendering::CameraSimulationOptions o = perfect();
  o.poor_texture_s = {2, 3};
  EXPECT_LT(gradient(taken(o, 2.5), 1, 0), 0.2 * gradient(taken(o, 1), 1, 0));
  EXPECT_NEAR(mean(taken(o, 2.5)), mean(taken(o, 1)), 15);
}

TEST(CameraSimulator, BlursAlongTheMotionOnly) {
  vir::rendering::CameraSimulationOptions o = perfect();
  const vir::rendering::GrayImage sharp = taken(o, 1, 0, turning);
  o.exposure_s = 0.02;  // 9 px
  const vir::rendering::GrayImage blurred = taken(o, 1, 0, turning);
  EXPECT_LT(gradient(blurred, 1, 0), 0.35 * gradient(sharp, 1, 0));
  EXPECT_GT(gradient(blurred, 0, 1), 0.35 * gradient(sharp, 0, 1));
  EXPECT_NEAR(mean(blurred), mean(sharp), 1);
  // At rest the shutter time does not matter.
  const vir::rendering::GrayImage resting = taken(o);
  o.exposure_s = 0;
  EXPECT_EQ(resting.pixels, taken(o).pixels);
}

/// Every row of a rolling shutter is that of an image taken at the row's own time.
TEST(CameraSimulator, RowsOfARollingShutterAreSeenOneAfterTheOther) {
  vir::rendering::CameraSimulationOptions o = perfect();
  o.readout_s = 0.03;
  o.exposure_s = 0.005;
  const vir::rendering::GrayImage rolling = taken(o, 1, 0, turning);
  o.readout_s = 0;
  const int h = rolling.height, w = rolling.width, band = 8;
  int moved = 0;
  for (int first = 0; first + band <= h; first += band) {
    const double dt = 0.03 * ((first + 0.5 * (band - 1)) / h - 0.5);
    const vir::rendering::GrayImage then =
        taken(o, 1, 0, [dt](double s) { return turning(dt + s); });
    for (int k = first * w; k < (first + band) * w; ++k) {
      const auto at = static_cast<std::size_t>(k);
      ASSERT_EQ(rolling.pixels[at], then.pixels[at]) << "row " << k / w << ", column " << k % w;
    }
    const vir::rendering::GrayImage middle = first == 0 ? taken(o, 1, 0, turning) : then;
    for (int k = 0; first == 0 && k < band * w; ++k) {
      const auto at = static_cast<std::size_t>(k);
      moved += std::abs(rolling.pixels[at] - middle.pixels[at]) > 2;
    }
  }
  EXPECT_GT(moved, w) << "the first rows are seen 15 ms, or 7 px, earlier";
}

TEST(CameraSimulator, RefusesHalfAPair) {
  vir::rendering::CameraSimulationOptions o;
  o.dark_s = {1};
  EXPECT_THROW(simulator(o), std::invalid_argument);
  o.dark_s.clear();
  o.exposure_jump = {1, 2, 3};
  EXPECT_THROW(simulator(o), std::invalid_argument);
}

}  // namespace
