#include "vir/vision/rig_tracker.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "synthetic_view.h"

namespace vir::vision {
namespace {

using test::lookingDown;
using test::smallCamera;
using test::SyntheticPlane;

constexpr TimeNs kStep = 50000000;

/// Two cameras side by side that look down on a textured plane, `height_m` below.
struct Rig {
  explicit Rig(double right_turned = 0, Distortion lens = Distortion::radtan) {
    left = camera::makeCamera(smallCamera());
    right = camera::makeCamera(smallCamera(lens));
    T_B_right = Pose(expQuat(Vec3(0.01, right_turned, 0.02)), Vec3(0.1, 0.004, 0.002));
    tracker = std::make_unique<RigTracker>(
        options(), std::vector<RigTracker::Camera>{{left, Pose()}, {right, T_B_right}});
  }
  static TrackerOptions options() {
    TrackerOptions o;
    o.max_tracks = 120;
    o.min_distance_px = 20;
    o.grid_cell_px = 40;
    return o;
  }
  Pose bodyAt(int k) const { return lookingDown(Vec3(0.02 * k, 0.01 * k, 1.2)); }
  std::vector<RigImage> images(int k) const {
    std::vector<RigImage> out(2);
    out[0].gray = plane.render(*left, bodyAt(k));
    out[1].gray = plane.render(*right, bodyAt(k) * T_B_right);
    for (int c = 0; c < 2; ++c) {
      out[static_cast<std::size_t>(c)].camera = c;
      out[static_cast<std::size_t>(c)].t = k * kStep;
    }
    return out;
  }
  /// Features that both see, and the worst error of the right one's against the exact image [px].
  int pairs(const TrackedFrame& frame, double* worst) const {
    int n = 0;
    for (const FeatureObservation& r : frame.further) {
      for (const FeatureObservation& l : frame.features) {
        if (l.id != r.id) continue;
        ++n;
        const Pose T_W_left = bodyAt(static_cast<int>(frame.t / kStep));
        const Vec3 ray = T_W_left.q * l.bearing;
        const Vec3 p_W = T_W_left.p - T_W_left.p.z() / ray.z() * ray;
        Vec2 truth;
        EXPECT_TRUE(right->project((T_W_left * T_B_right).inverse() * p_W, &truth));
        *worst = std::max(*worst, (truth - r.px).norm());
      }
    }
    return n;
  }

  SyntheticPlane plane;
  std::shared_ptr<const camera::CameraModel> left, right;
  Pose T_B_right;
  std::unique_ptr<RigTracker> tracker;
};

TEST(RigTracker, FindsWhatBothSeeAndFollowsItUnderOneId) {
  for (const Distortion lens : {Distortion::radtan, Distortion::equidistant}) {
    Rig rig(0, lens);
    EXPECT_TRUE(rig.tracker->overlap(0, 1));
    std::vector<std::uint64_t> first;
    for (int k = 0; k < 4; ++k) {
      const TrackedFrame frame = rig.tracker->process(k * kStep, rig.images(k));
      double worst = 0;
      EXPECT_GE(rig.pairs(frame, &worst), 25) << k;
      EXPECT_LT(worst, 0.5) << k;  // any pixel beside would be another corner, 20 px away
      for (const FeatureObservation& f : frame.further) {
        EXPECT_EQ(f.camera, 1);
        if (k == 0) first.push_back(f.id);
      }
      if (k < 3) continue;
      const auto kept = std::count_if(
          frame.further.begin(), frame.further.end(), [&first](const FeatureObservation& f) {
            return std::find(first.begin(), first.end(), f.id) != first.end();
          });
      EXPECT_GE(kept, static_cast<long>(first.size()) / 2);
    }
    EXPECT_LT(rig.tracker->epipolarPx(), 0.3);
  }
}

TEST(RigTracker, BackToBackThereIsNothingToMatch) {
  Rig rig(3.14);
  EXPECT_FALSE(rig.tracker->overlap(0, 1));
  EXPECT_FALSE(rig.tracker->overlap(1, 0));
}

TEST(RigTracker, GoesOnWithTheCameraThatSees) {
  Rig rig;
  rig.tracker->process(0, rig.images(0));
  std::vector<RigImage> images = rig.images(1);
  images[0].gray.setTo(0);
  std::vector<RigOutcome> outcomes;
  TrackedFrame frame = rig.tracker->process(kStep, images, &outcomes);
  EXPECT_TRUE(frame.usable);
  EXPECT_TRUE(frame.features.empty());
  EXPECT_GE(frame.further.size(), 25u);
  ASSERT_EQ(outcomes.size(), 2u);
  EXPECT_FALSE(outcomes[0].usable);
  EXPECT_NE(outcomes[0].reason.find("blank"), std::string::npos) << outcomes[0].reason;
  EXPECT_TRUE(outcomes[1].usable);
  // Without the first, and then with both again.
  images = {rig.images(2)[1]};
  frame = rig.tracker->process(2 * kStep, images);
  EXPECT_TRUE(frame.usable);
  EXPECT_GE(frame.further.size(), 25u);
  frame = rig.tracker->process(3 * kStep, rig.images(3));
  double worst = 0;
  EXPECT_GE(rig.pairs(frame, &worst), 20);
}

TEST(RigTracker, SaysWhyAnImageIsNotUsed) {
  Rig rig;
  rig.tracker->process(0, rig.images(0));
  std::vector<RigImage> images = rig.images(1);
  images[1].gray = rig.images(0)[1].gray;  // hangs
  std::vector<RigOutcome> outcomes;
  rig.tracker->process(kStep, images, &outcomes);
  EXPECT_TRUE(outcomes[0].usable);
  EXPECT_FALSE(outcomes[1].usable);
  EXPECT_NE(outcomes[1].reason.find("hangs"), std::string::npos) << outcomes[1].reason;
  images = rig.images(2);
  images[1].gray = cv::Mat(100, 100, CV_8UC1, cv::Scalar(7));
  outcomes.clear();
  rig.tracker->process(2 * kStep, images, &outcomes);
  EXPECT_NE(outcomes[1].reason.find("100x100"), std::string::npos) << outcomes[1].reason;
  // Left for right: what is matched, if anything, is none of the points.
  images = rig.images(3);
  std::swap(images[0].gray, images[1].gray);
  EXPECT_NO_THROW(rig.tracker->process(3 * kStep, images));
}

}  // namespace
}  // namespace vir::vision
