/// Several cameras on one robot of a made-up world.
#include "rig.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "input_error.h"
#include "vir/core/settings.h"
#include "world.h"

namespace vir::simulator {
namespace {

/// As an ini would say it: defaults of the further cameras come from the first.
SimulatorOptions read(const std::vector<std::string>& assignments) {
  Settings settings;
  for (const char* a : {"simulator.cameras=2", "Flight.length_m=8", "Camera.width_px=96",
                        "Camera.height_px=64", "Camera.fx_px=60", "Camera.fy_px=60",
                        "Camera.cx_px=48", "Camera.cy_px=32", "Camera.distortion=none"}) {
    settings.set(a);
  }
  for (const std::string& a : assignments) settings.set(a);
  SimulatorOptions o;
  SettingsReader reader(settings);
  describe(reader, o);
  reader.finish();
  return o;
}

std::vector<Event> imagesOf(const World& world, int camera) {
  std::vector<Event> out;
  for (const Event& e : world.events()) {
    const auto* due = std::get_if<ImageDue>(&e.what);
    if (due != nullptr && due->camera == camera) out.push_back(e);
  }
  return out;
}

TEST(SimulatedRig, FurtherCamerasStandBesideTheFirst) {
  const SimulatorOptions o = read({"simulator.cameras=3", "Camera.tilt_deg=20"});
  ASSERT_EQ(o.further_cameras.size(), 2u);
  const Rig rig(o);
  for (int k = 1; k < 3; ++k) {
    const Pose between = rig.T_B_C(0).inverse() * rig.T_B_C(k);
    EXPECT_NEAR(between.p.x(), 0.11 * k, 1e-12);  // to the right, in the image's axes
    EXPECT_NEAR(between.p.tail<2>().norm(), 0, 1e-12);
    EXPECT_NEAR(logQuat(between.q).norm(), 0, 1e-12);
    EXPECT_EQ(rig.calibration(k).fx, 60);
  }
}

TEST(SimulatedRig, MountsLookWhereTheySay) {
  const auto axis = [](const char* mount) {
    const SimulatorOptions o = read({std::string("Camera1.mount=") + mount});
    return Vec3(mountOf(o.further_cameras[0]).q * Vec3::UnitZ());
  };
  EXPECT_LT((axis("forward") - Vec3::UnitX()).norm(), 1e-12);
  EXPECT_LT((axis("backward") + Vec3::UnitX()).norm(), 1e-12);
  EXPECT_LT((axis("left") - Vec3::UnitY()).norm(), 1e-12);
  EXPECT_LT((axis("right") + Vec3::UnitY()).norm(), 1e-12);
  EXPECT_LT((axis("down") + Vec3::UnitZ()).norm(), 1e-12);
}

TEST(SimulatedRig, ErrorsAreEachCamerasOwn) {
  const Rig rig(
      read({"Camera.focal_error=0.01", "Camera.mount_error_deg=1", "Camera.mount_error_m=0.01"}));
  EXPECT_NE(rig.model(0)->calibration().fx, rig.model(1)->calibration().fx);
  const Pose off0 = rig.T_B_C(0).inverse() * rig.trueT_B_C(0);
  const Pose off1 = rig.T_B_C(1).inverse() * rig.trueT_B_C(1);
  EXPECT_GT(off0.p.norm(), 1e-3);
  EXPECT_GT((off0.p - off1.p).norm(), 1e-3);
  EXPECT_GT(logQuat(off0.q.conjugate() * off1.q).norm(), 1e-3);
}

TEST(SimulatedRig, OneCameraIsAsBefore) {
  const SimulatorOptions one = read({"simulator.cameras=1"});
  World alone(one), pair(read({}));
  const auto a = imagesOf(alone, 0), b = imagesOf(pair, 0);
  ASSERT_EQ(a.size(), b.size());
  EXPECT_EQ(alone.image(a[5]).pixels, pair.image(b[5]).pixels);
  EXPECT_TRUE(imagesOf(alone, 1).empty());
  EXPECT_EQ(imagesOf(pair, 1).size(), b.size());
}

TEST(SimulatedRig, TheRightCameraSeesThingsFartherLeft) {
  World world(
      read({"Camera.focal_error=0", "Camera.mount_error_deg=0", "SimulatedCamera.noise_grey=0",
            "SimulatedCamera.shot_noise=0", "Camera1.position_m=0.05 -0.28 -0.01"}));
  const Event left = imagesOf(world, 0)[3], right = imagesOf(world, 1)[3];
  EXPECT_EQ(left.t, right.t);
  const auto l = world.image(left).pixels, r = world.image(right).pixels;
  const auto difference = [&](int shift) {
    double sum = 0;
    for (int y = 8; y < 56; ++y) {
      for (int x = 24; x < 72; ++x) {
        const auto at = [&](const std::vector<std::uint8_t>& p, int column) {
          return static_cast<double>(p[static_cast<std::size_t>(y * 96 + column)]);
        };
        sum += std::abs(at(l, x) - at(r, x - shift));
      }
    }
    return sum;
  };
  double best = 1e300;
  int found = -100;
  for (int shift = -12; shift <= 12; ++shift) {
    if (difference(shift) < best) best = difference(shift), found = shift;
  }
  EXPECT_GE(found, 1);
}

TEST(SimulatedRig, ClocksAndRatesAreEachCamerasOwn) {
  const World world(
      read({"Camera1.rate_hz=10", "Camera1.time_offset_s=0.02", "Camera1.clock_error_s=0.005"}));
  const auto a = imagesOf(world, 0), b = imagesOf(world, 1);
  EXPECT_EQ(b[0].t, a[0].t - 25000000);
  EXPECT_EQ(b[1].t - b[0].t, 100000000);
}

TEST(SimulatedRig, ACameraMayFail) {
  World world(read({"Camera1.black_s=1 2", "Camera1.frozen_s=2 3", "Camera1.missing_s=3 4",
                    "Camera1.half_rate_s=4 5"}));
  EXPECT_EQ(imagesOf(world, 0).size(), imagesOf(world, 1).size() + 30);
  std::vector<std::uint8_t> last;
  for (const Event& e : imagesOf(world, 1)) {
    const double s = toSeconds(e.t - world.motion().begin());
    const auto& pixels = world.image(e).pixels;
    if (s >= 1 && s < 2) {
      EXPECT_EQ(*std::max_element(pixels.begin(), pixels.end()), 0);
    }
    if (s >= 2.01 && s < 3) {
      EXPECT_EQ(pixels, last) << s;
    }
    EXPECT_FALSE(s >= 3 && s < 4);
    last = pixels;
  }
}

TEST(SimulatedRig, ListsOfOddLengthAreRefused) {
  try {
    World world(read({"Camera1.black_s=1 2 3"}));
    FAIL();
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("black_s must hold pairs"), std::string::npos);
  }
}

}  // namespace
}  // namespace vir::simulator
