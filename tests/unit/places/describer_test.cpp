/// Points of a rendered place are found again turned, in other light and from elsewhere.
#include "vir/places/describer.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <stdexcept>

#include "rendered_places.h"
#include "vir/core/angles.h"
#include "vir/places/hamming.h"
#include "vir/rendering/make_scene.h"

namespace {

using namespace vir;
using places::Describer;
using places::SeenLandmark;
using vir_test::bodyAt;
using vir_test::PlaceMaker;

std::shared_ptr<const rendering::Scene> room() {
  std::vector<Vec3> path;
  for (int k = 0; k < 20; ++k) path.emplace_back(0.25 * k, 0.5 * std::sin(0.5 * k), 0);
  return std::make_shared<rendering::Scene>(rendering::makeScene({}, path, {}));
}

PlaceMaker maker(double gain = 1) {
  rendering::CameraSimulationOptions o;
  o.exposure_jump = {0, gain};
  o.seed = gain < 1 ? 2 : 1;
  return {room(), vir_test::eurocCamera(0.5), o};
}

/// Where points with known distance of `a` are in `b`, and whether the most alike descriptor of b
/// is there: share of those that are in view and have any point of b within 3 px.
struct Again {
  int asked = 0, right = 0;
  double share() const { return asked > 0 ? static_cast<double>(right) / asked : 0; }
};
Again foundAgain(const PlaceKeyframe& a, const PlaceKeyframe& b,
                 const camera::CameraModel& camera) {
  constexpr float kNear_px = 3;
  const Pose T_B_A = (b.T_W_B * b.T_B_C).inverse() * (a.T_W_B * a.T_B_C);
  Again out;
  for (const PlacePoint& p : a.points) {
    if (p.inverse_distance <= 0) continue;
    Vec2 px;
    if (!camera.project(T_B_A * Vec3(p.ray_C.cast<double>() / p.inverse_distance), &px)) continue;
    const Eigen::Vector2f at = px.cast<float>();
    bool near = false;
    int best = 257;
    Eigen::Vector2f best_at = Eigen::Vector2f::Zero();
    for (const PlacePoint& q : b.points) {
      near = near || (q.px - at).norm() < kNear_px;
      const int d = places::hammingDistance(p.descriptor, q.descriptor);
      if (d >= best) continue;
      best = d;
      best_at = q.px;
    }
    if (!near) continue;
    ++out.asked;
    out.right += (best_at - at).norm() < kNear_px;
  }
  return out;
}

/// `move` from a few places; the second look is under `gain` of the light.
Again lookTwice(const Pose& move, double gain, double pitch = 0) {
  PlaceMaker first = maker(), second = maker(gain);
  first.distance_sigma = 0.001;
  Again sum;
  for (int k = 0; k < 4; ++k) {
    const Pose at = bodyAt(Vec3(0.8 + 0.6 * k, 0.2, 0), 0.4 + 1.5 * k, pitch);
    const auto a = first.keyframe(1, fromSeconds(1), at);
    const auto b = second.keyframe(2, fromSeconds(1), at * move);
    const Again one = foundAgain(*a, *b, *first.camera());
    sum.asked += one.asked;
    sum.right += one.right;
  }
  return sum;
}

TEST(Describer, FindsPointsAgainInOtherLight) {
  const Again again = lookTwice({Quat::Identity(), Vec3(0.02, 0.05, 0.02)}, 0.6);
  EXPECT_GT(again.asked, 60);
  EXPECT_GT(again.share(), 0.85);
}

TEST(Describer, FindsPointsAgainWhenTheCameraRolls) {
  const Again again = lookTwice({expQuat(Vec3(0.6, 0, 0)), Vec3(0.02, 0.05, 0.02)}, 1);
  EXPECT_GT(again.asked, 60);
  EXPECT_GT(again.share(), 0.75);
}

TEST(Describer, FindsPointsAgainNearer) {
  const Again again = lookTwice({Quat::Identity(), Vec3(0.35, 0.05, 0.02)}, 1);
  EXPECT_GT(again.asked, 60);
  EXPECT_GT(again.share(), 0.6);
}

TEST(Describer, FindsPointsAgainLookingDownAndTurned) {
  // Straight down there is no "down" in the image.
  const Pose turn(
      Quat(expQuat(Vec3(0, -0.5 * kPi, 0)) * Quat(rotZ(1.2)) * expQuat(Vec3(0, 0.5 * kPi, 0))),
      Vec3(0.02, 0.05, 0.02));
  const Again again = lookTwice(turn, 1, 0.5 * kPi);
  EXPECT_GT(again.asked, 40);
  EXPECT_GT(again.share(), 0.5);
}

class DescriberInput : public testing::Test {
 protected:
  DescriberInput() : maker_(maker()), describer_({}, maker_.camera()) {
    const rendering::GrayImage& taken = maker_.take(bodyAt(Vec3(1, 0, 0), 0.3));
    pixels_ = taken.pixels;
    image_.width = taken.width;
    image_.height = taken.height;
    image_.pixels = pixels_.data();
  }
  std::vector<PlacePoint> points(const std::vector<SeenLandmark>& landmarks = {}) {
    return describer_.points(image_, vir_test::cameraInBody().q, landmarks);
  }
  PlaceMaker maker_;
  Describer describer_;
  std::vector<std::uint8_t> pixels_;
  Image image_;
};

TEST_F(DescriberInput, LandmarksComeFirstAsTheyWereGiven) {
  const std::vector<SeenLandmark> landmarks{
      {Vec2(100.25, 80.5), 0.4, 0.02}, {Vec2(200.75, 120), 0, 0}, {Vec2(260, 170.5), 0.2, 0}};
  const std::vector<PlacePoint> all = points(landmarks);
  ASSERT_GT(all.size(), 60U);
  EXPECT_LE(all.size(), 200U);
  for (std::size_t k = 0; k < landmarks.size(); ++k) {
    EXPECT_EQ(all[k].px, landmarks[k].px.cast<float>());
    EXPECT_NEAR(all[k].ray_C.norm(), 1, 1e-6);
    Vec2 px;
    ASSERT_TRUE(maker_.camera()->project(all[k].ray_C.cast<double>(), &px));
    EXPECT_LT((px - landmarks[k].px).norm(), 0.02);
  }
  EXPECT_FLOAT_EQ(all[0].inverse_distance, 0.4f);
  EXPECT_FLOAT_EQ(all[0].inverse_distance_sigma, 0.02f);
  // A distance of which nobody says how well it is known is none.
  EXPECT_EQ(all[1].inverse_distance, 0);
  EXPECT_EQ(all[2].inverse_distance, 0);
  for (std::size_t k = 3; k < all.size(); ++k) {
    EXPECT_EQ(all[k].inverse_distance, 0);
    for (std::size_t j = 0; j < k; ++j) EXPECT_GE((all[k].px - all[j].px).norm(), 10 - 1e-3);
  }
}

TEST_F(DescriberInput, CornersAreAllOverTheImage) {
  int in[2][2] = {{0, 0}, {0, 0}};
  const std::vector<PlacePoint> all = points();
  for (const PlacePoint& p : all) {
    ++in[p.px.y() > 0.5f * image_.height][p.px.x() > 0.5f * image_.width];
  }
  for (const auto& row : in) {
    for (const int n : row) EXPECT_GT(n, static_cast<int>(all.size() / 12));
  }
}

TEST_F(DescriberInput, SameImageSamePointsWhateverTheStride) {
  const auto same = [](const std::vector<PlacePoint>& a, const std::vector<PlacePoint>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [](const PlacePoint& p, const PlacePoint& q) {
                        return p.px == q.px && p.descriptor == q.descriptor;
                      });
  };
  const std::vector<PlacePoint> first = points();
  EXPECT_TRUE(same(first, points()));
  const auto w = static_cast<std::size_t>(image_.width);
  std::vector<std::uint8_t> padded(static_cast<std::size_t>(image_.height) * (w + 24), 99);
  for (std::size_t y = 0; y < static_cast<std::size_t>(image_.height); ++y) {
    std::copy_n(pixels_.begin() + static_cast<std::ptrdiff_t>(y * w), w,
                padded.begin() + static_cast<std::ptrdiff_t>(y * (w + 24)));
  }
  image_.pixels = padded.data();
  image_.stride = w + 24;
  EXPECT_TRUE(same(first, points()));
}

TEST_F(DescriberInput, LandmarksThatAreNoneAreLeftOut) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  const std::size_t none = points().size();
  const std::vector<PlacePoint> all = points({{Vec2(nan, 80), 0.4, 0.02},
                                              {Vec2(100, inf), 0.4, 0.02},
                                              {Vec2(-1e300, 5), 0.4, 0.02},
                                              {Vec2(100, 80), nan, 0.02},
                                              {Vec2(3, 3), 0.4, 0.02},
                                              {Vec2(375, 239), 0.4, 0.02}});
  EXPECT_EQ(all.size(), none);
  for (const PlacePoint& p : all) EXPECT_EQ(p.inverse_distance, 0);
}

TEST_F(DescriberInput, NoPointsOfAnImageThatIsNone) {
  const Quat upright = vir_test::cameraInBody().q;
  Image other = image_;
  other.width -= 1;
  other.stride = static_cast<std::size_t>(image_.width);
  EXPECT_TRUE(describer_.points(other, upright, {}).empty());
  other = image_;
  other.pixels = nullptr;
  EXPECT_TRUE(describer_.points(other, upright, {}).empty());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(describer_.points(image_, Quat(nan, 0, 0, 0), {}).empty());
  std::fill(pixels_.begin(), pixels_.end(), std::uint8_t{128});
  EXPECT_TRUE(points().empty());
  EXPECT_THROW(Describer({}, nullptr), std::invalid_argument);
  places::DescriberOptions o;
  o.points = 0;
  EXPECT_THROW(Describer(o, maker_.camera()), std::invalid_argument);
}

/// What a corner looked like is there in the image, and is not 40 px beside it; in other light too.
TEST(Describer, ComparesWhatIsExpectedWithWhatIsThere) {
  PlaceMaker bright = maker(), dim = maker(0.6);
  const Pose at = bodyAt(Vec3(1, 0, 0.2), 0.3, 0.02, -0.03);
  const auto k = bright.keyframe(0, 0, at);
  std::vector<places::ExpectedPoint> there, beside, behind;
  for (const PlacePoint& p : k->points) {
    const Vec3 ray = p.ray_C.cast<double>();
    there.push_back({ray, p.descriptor});
    beside.push_back({ray / ray.z() + Vec3(40 / 229.0, 0, 0), p.descriptor});
    behind.push_back({-ray, p.descriptor});
  }
  const auto alike = [](const std::vector<int>& all, int* seen) {
    *seen = static_cast<int>(std::count_if(all.begin(), all.end(), [](int b) { return b >= 0; }));
    return static_cast<double>(
               std::count_if(all.begin(), all.end(), [](int b) { return b >= 0 && b < 70; })) /
           std::max(1, *seen);
  };
  const auto image = dim.take(at);
  int seen = 0;
  EXPECT_GT(alike(dim.compare(image, at, there), &seen), 0.95);
  EXPECT_EQ(seen, static_cast<int>(there.size()));
  EXPECT_LT(alike(dim.compare(image, at, beside), &seen), 0.3);
  EXPECT_GT(seen, 40);
  alike(dim.compare(image, at, behind), &seen);
  EXPECT_EQ(seen, 0);
}

}  // namespace
