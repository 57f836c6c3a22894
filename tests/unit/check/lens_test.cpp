/// Focal length and lens, told apart by what points do near the middle and near the rim.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "found.h"
#include "vir/check/turning_check.h"
#include "vir/core/random.h"

namespace vir::check {
namespace {

Vec3 rate(double t) {
  return {0.7 * std::sin(1.1 * t), 0.5 * std::cos(0.8 * t), 0.6 * std::sin(0.6 * t + 1)};
}

/// The ray that a camera of another focal length (`scale` of the one given) or lens is taken to
/// see where the true one is `x`, y at depth 1: x = given (1 + bend r^2) / scale.
Vec2 asGiven(const Vec2& x, double scale, double bend) {
  Vec2 given = scale * x;
  for (int i = 0; i < 50; ++i) given = scale * x / (1 + bend * given.squaredNorm());
  return given;
}

/// 20 s at 200 Hz, images at 20 Hz of a cloud of points the camera flies by and turns in.
std::vector<Finding> findingsWith(double scale, double bend) {
  TurningCheck check("IMU0", "CAM0");
  Random random(6);
  Mat3 R = Mat3::Identity(), R_before = R;  // of the camera, which has the body's axes
  for (int i = 0; i < 4000; ++i) {
    const double t = 0.005 * i;
    if (i % 10 == 0 && i > 0) {
      ImageTurn turn;
      turn.t0 = fromSeconds(t - 0.05);
      turn.t1 = fromSeconds(t);
      const Mat3 R_C0_C1 = R_before.transpose() * R;
      const Vec3 step = 0.04 * Vec3(std::sin(0.4 * t), std::cos(0.7 * t), std::sin(0.9 * t + 2));
      turn.rotation_C =
          logSO3(R_C0_C1) + 0.001 * Vec3(random.normal(), random.normal(), random.normal());
      for (int k = 0; k < 60; ++k) {
        const Vec2 x(0.7 * std::sin(3.7 * k + i), 0.5 * std::cos(2.3 * k + 2 * i));
        const Vec3 p = (2 + 3 * std::abs(std::sin(1.3 * k))) * Vec3(x.x(), x.y(), 1);
        const Vec3 q = R_C0_C1.transpose() * (p - step);
        if (q.z() < 0.3) continue;
        const Vec2 a = asGiven(x, scale, bend), b = asGiven(q.head<2>() / q.z(), scale, bend);
        const double noise = 0.0005;
        turn.matches.push_back(
            Eigen::Vector4d(a.x() + noise * random.normal(), a.y() + noise * random.normal(),
                            b.x() + noise * random.normal(), b.y() + noise * random.normal())
                .cast<float>());
      }
      turn.points = static_cast<int>(turn.matches.size());
      check.add(turn);
      R_before = R;
    }
    check.add(ImuSample{fromSeconds(t), rate(t), Vec3(0, 0, 9.81)});
    R = R * expSO3(0.005 * rate(t + 0.0025));
  }
  return check.findings(Mat3::Identity(), 0);
}

TEST(Lens, NothingIsWrongWithTheRightOne) {
  EXPECT_EQ(seriousKinds(findingsWith(1, 0)), Kinds{});
  // An estimate finds so much by itself.
  EXPECT_EQ(seriousKinds(findingsWith(1.02, 0.02)), Kinds{});
}

TEST(Lens, NamesAFocalLength) {
  for (const double scale : {0.8, 0.9, 1.15}) {
    const auto findings = findingsWith(scale, 0);
    ASSERT_EQ(seriousKinds(findings), Kinds{"camera_focal"}) << scale;
    for (const Finding& f : findings) {
      if (f.kind != "camera_focal") continue;
      const double said = std::stod(f.what.substr(f.what.find("with ") + 5));
      EXPECT_NEAR(said, scale, 0.03) << f.what;
    }
  }
}

TEST(Lens, NamesALens) {
  EXPECT_EQ(seriousKinds(findingsWith(1, 0.4)), Kinds{"camera_lens"});
  EXPECT_EQ(seriousKinds(findingsWith(1, -0.15)), Kinds{"camera_lens"});
}

}  // namespace
}  // namespace vir::check
