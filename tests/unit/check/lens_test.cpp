/// Focal length and lens, told apart by what points do near the middle and near the rim.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <string>

#include "found.h"
#include "vir/camera/camera_model.h"
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

/// What a ray, x and y at depth 1, is taken for; false: it is not seen.
using Lens = std::function<bool(const Vec2&, Vec2*)>;

/// 20 s at 200 Hz, images at 20 Hz of a cloud of points the camera flies by and turns in.
std::vector<Finding> findingsThrough(const Lens& lens,
                                     const std::optional<CameraCalibration>& given) {
  TurningCheck check("IMU0", "CAM0");
  if (given) check.setCamera(*given);
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
        Vec2 a, b;
        if (!lens(x, &a) || !lens(q.head<2>() / q.z(), &b)) continue;
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

std::vector<Finding> findingsWith(double scale, double bend) {
  return findingsThrough(
      [&](const Vec2& x, Vec2* seen) {
        *seen = asGiven(x, scale, bend);
        return true;
      },
      std::nullopt);
}

CameraCalibration cameraWith(Distortion model, const std::array<double, 8>& dist) {
  CameraCalibration c;
  c.width = 752;
  c.height = 480;
  c.fx = c.fy = 400;
  c.cx = 376;
  c.cy = 240;
  c.distortion = model;
  c.dist = dist;
  return c;
}

/// Of a camera whose calibration names a model, of its own or of another one.
std::vector<Finding> findingsOf(const CameraCalibration& truth, Distortion named) {
  CameraCalibration wrong = truth;
  wrong.distortion = named;
  const auto real = camera::makeCamera(truth), given = camera::makeCamera(wrong);
  return findingsThrough(
      [&](const Vec2& x, Vec2* seen) {
        Vec2 px;
        Vec3 bearing;
        if (!real->project(Vec3(x.x(), x.y(), 1), &px) || !given->unproject(px, &bearing))
          return false;
        *seen = bearing.head<2>() / bearing.z();
        return bearing.z() > 0.2;
      },
      wrong);
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

/// Radtan and equidistant exchanged in the file.
TEST(Lens, NamesTheModelThatTheCoefficientsAreOf) {
  const CameraCalibration euroc = cameraWith(Distortion::radtan, {-0.283, 0.074, 0.0002, 0.00002});
  const CameraCalibration fisheye =
      cameraWith(Distortion::equidistant, {0.0034, 0.0007, -0.002, 0.0002});
  for (const CameraCalibration& truth : {euroc, fisheye}) {
    const bool radtan = truth.distortion == Distortion::radtan;
    const auto wrong = findingsOf(truth, radtan ? Distortion::equidistant : Distortion::radtan);
    ASSERT_EQ(seriousKinds(wrong), Kinds{"camera_lens"}) << radtan;
    EXPECT_NE(wrong[0].what.find(radtan ? "are those of radtan" : "are those of equidistant"),
              std::string::npos)
        << wrong[0].what;
    EXPECT_EQ(seriousKinds(findingsOf(truth, truth.distortion)), Kinds{}) << radtan;
  }
}

}  // namespace
}  // namespace vir::check
