#include "vir/check/force_sign.h"

#include <gtest/gtest.h>

#include <cmath>

#include "vir/core/random.h"

namespace vir::check {
namespace {

/// A camera carried about among points: sways, turns, and looks along its own z.
struct Scene {
  Scene() {
    Random random(4);
    for (int i = 0; i < 400; ++i) {
      points.emplace_back(random.uniform(-4, 4), random.uniform(-3, 3), random.uniform(3, 9));
    }
  }
  static Vec3 position(double t) {
    return {std::sin(1.7 * t), 0.5 * std::sin(2.3 * t + 1), 0.4 * std::sin(1.3 * t + 2)};
  }
  static Vec3 acceleration(double t) {
    return {-1.7 * 1.7 * std::sin(1.7 * t), -0.5 * 2.3 * 2.3 * std::sin(2.3 * t + 1),
            -0.4 * 1.3 * 1.3 * std::sin(1.3 * t + 2)};
  }
  /// About one axis, so that its rate is the derivative of the angle.
  static Vec3 axis() { return Vec3(1, 2, -1).normalized(); }
  static Mat3 attitude(double t) { return expSO3(0.3 * std::sin(0.9 * t) * axis()); }
  static Vec3 rate(double t) { return 0.27 * std::cos(0.9 * t) * axis(); }

  /// `sign`: of the accelerometer. Down is y, as for a camera that is held level.
  std::vector<ImuSample> samples(double sign) const {
    std::vector<ImuSample> out;
    for (int i = 0; i < 2400; ++i) {
      const double t = 0.005 * i;
      const Vec3 force = acceleration(t) - Vec3(0, 9.81, 0);
      out.push_back({fromSeconds(t), rate(t), sign * (attitude(t).transpose() * force)});
    }
    return out;
  }
  /// `late_s`: by how much the images' stamps are after their time. `mirror`: left to right.
  std::vector<ImageTurn> turns(double late_s, bool mirror) const {
    std::vector<ImageTurn> out;
    Random random(6);
    const auto seen = [&](double t, const Vec3& p) {
      const Vec3 p_C = attitude(t).transpose() * (p - position(t));
      const double noise = 0.0005;
      Vec2 xy = p_C.head<2>() / p_C.z() + noise * Vec2(random.normal(), random.normal());
      if (mirror) xy.x() = -xy.x();
      return Eigen::Vector2f(xy.cast<float>());
    };
    for (int i = 1; i < 220; ++i) {
      const double t0 = 0.05 * i, t1 = t0 + 0.05;
      ImageTurn turn;
      turn.t0 = fromSeconds(t0 + late_s);
      turn.t1 = fromSeconds(t1 + late_s);
      for (const Vec3& p : points) {
        Eigen::Vector4f match;
        const Eigen::Vector2f before = seen(t0, p), after = seen(t1, p);
        match << before.x(), before.y(), after.x(), after.y();
        turn.matches.push_back(match);
      }
      out.push_back(turn);
    }
    return out;
  }
  std::vector<Vec3> points;
};

TEST(ForceSign, TellsANegatedAccelerometer) {
  const Scene scene;
  const auto turns = scene.turns(0, false);
  const ForceSign right = forceSign(turns, scene.samples(1), Mat3::Identity(), 0);
  EXPECT_EQ(right.sign(), 1) << right.with << " " << right.against;
  const ForceSign wrong = forceSign(turns, scene.samples(-1), Mat3::Identity(), 0);
  EXPECT_EQ(wrong.sign(), -1) << wrong.with << " " << wrong.against;
  EXPECT_EQ(right.with, wrong.against);
}

/// The rotation that mirrored images seem to have: half a turn about x.
TEST(ForceSign, TellsMirroredImages) {
  const Scene scene;
  const Mat3 seeming = Vec3(1, -1, -1).asDiagonal();
  EXPECT_EQ(forceSign(scene.turns(0, true), scene.samples(1), seeming, 0).sign(), -1);
}

TEST(ForceSign, TakesTheOffsetOfTheClocks) {
  const Scene scene;
  EXPECT_EQ(forceSign(scene.turns(0.2, false), scene.samples(1), Mat3::Identity(), -0.2).sign(), 1);
}

TEST(ForceSign, TooLittleSaysNothing) {
  const Scene scene;
  EXPECT_EQ(forceSign({}, scene.samples(1), Mat3::Identity(), 0).sign(), 0);
  auto turns = scene.turns(0, false);
  EXPECT_EQ(forceSign(turns, {}, Mat3::Identity(), 0).sign(), 0);
  for (ImageTurn& t : turns) t.matches.clear();
  EXPECT_EQ(forceSign(turns, scene.samples(1), Mat3::Identity(), 0).sign(), 0);
  turns.resize(1);
  turns[0].t1 = turns[0].t0 + fromSeconds(9);
  EXPECT_EQ(forceSign(turns, scene.samples(1), Mat3::Identity(), 0).sign(), 0);
}

}  // namespace
}  // namespace vir::check
