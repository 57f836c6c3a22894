#include "vir/check/turning_check.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "found.h"
#include "vir/core/angles.h"
#include "vir/core/random.h"

namespace vir::check {
namespace {

/// Rate of the body at time `t` [rad/s].
Vec3 rate(double t) {
  return {0.7 * std::sin(1.1 * t), 0.5 * std::cos(0.8 * t), 0.6 * std::sin(0.6 * t + 1)};
}

constexpr TimeNs kDate = 1400000000000000000;

Mat3 forward() {
  Mat3 R_B_C;
  R_B_C << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return R_B_C;
}

/// 20 s at 200 Hz with images at 20 Hz, the gyro through `change`, the camera mounted `R_B_C` and
/// given as `told`.
template <typename Change>
std::vector<Finding> findingsOf(Change change, const Mat3& R_B_C, const Mat3& told) {
  TurningCheck check("IMU0", "CAM0");
  Random random(2);
  for (int i = 0; i < 4000; ++i) {
    const double t = 0.005 * i;
    if (i % 10 == 5 && i > 10) {
      ImageTurn turn;
      turn.t0 = fromSeconds(t - 0.05);
      turn.t1 = fromSeconds(t);
      const Vec3 noise(random.normal(), random.normal(), random.normal());
      turn.rotation_C = R_B_C.transpose() * rate(t - 0.025) * 0.05 + 0.001 * noise;
      check.add(turn);
    }
    check.add(ImuSample{fromSeconds(t), change(rate(t)), Vec3(0, 0, 9.81)});
  }
  return check.findings(told, 0);
}

const auto kAsItIs = [](const Vec3& w) { return w; };

TEST(TurningCheck, NothingIsWrongWithTheRightCalibration) {
  EXPECT_EQ(seriousKinds(findingsOf(kAsItIs, forward(), forward())), Kinds{});
  const Mat3 off = forward() * expSO3(Vec3(0.05, -0.05, 0.05));
  EXPECT_EQ(seriousKinds(findingsOf(kAsItIs, forward(), off)), Kinds{});
}

/// 20 s with images at 20 Hz whose stamps are off by up to `by_s`, each by itself.
std::vector<Finding> withStampsOff(double by_s) {
  TurningCheck check("IMU0", "CAM0");
  Random random(4);
  const auto turned = [](double from, double to) {
    Mat3 R = Mat3::Identity();
    for (double t = from; t < to; t += 0.001) R = R * expSO3(rate(t) * std::min(0.001, to - t));
    return R;
  };
  double taken = 0, stamped = 0;
  for (int i = 0; i < 4000; ++i) {
    const double t = 0.005 * i;
    check.add(ImuSample{fromSeconds(t), rate(t), Vec3(0, 0, 9.81)});
    if (i % 10 != 5) continue;
    const double at = t - 0.03, stamp = at + random.uniform(-by_s, by_s);
    ImageTurn turn;
    turn.t0 = fromSeconds(stamped);
    turn.t1 = fromSeconds(stamp);
    const Vec3 noise(random.normal(), random.normal(), random.normal());
    turn.rotation_C = forward().transpose() * logSO3(turned(taken, at)) + 0.0005 * noise;
    if (taken > 0) check.add(turn);
    taken = at;
    stamped = stamp;
  }
  return check.findings(forward(), 0);
}

TEST(TurningCheck, StampsThatScatterAreNamed) {
  EXPECT_EQ(seriousKinds(withStampsOff(0)), Kinds{});
  EXPECT_EQ(seriousKinds(withStampsOff(0.002)), Kinds{});
  const std::vector<Finding> found = withStampsOff(0.01);
  EXPECT_EQ(seriousKinds(found), Kinds{"jitter"});
  const auto jitter =
      std::find_if(found.begin(), found.end(), [](const Finding& f) { return f.kind == "jitter"; });
  ASSERT_NE(jitter, found.end());
  // 10 ms to both sides are 5.8 ms.
  const double told = std::stod(jitter->what.substr(jitter->what.find("about ") + 6));
  EXPECT_NEAR(told, 5.8, 1.2) << jitter->what;
}

/// Images stamped `late_s` late, given as `given_s`.
std::vector<Finding> offsetFound(double late_s, double given_s) {
  TurningCheck check("IMU0", "CAM0");
  Random random(3);
  for (int i = 0; i < 4000; ++i) {
    const double t = 0.005 * i;
    check.add(ImuSample{fromSeconds(t), rate(t), Vec3(0, 0, 9.81)});
    if (i % 10 != 5 || i < 60) continue;
    ImageTurn turn;
    turn.t0 = fromSeconds(t - 0.05);
    turn.t1 = fromSeconds(t);
    const Vec3 noise(random.normal(), random.normal(), random.normal());
    turn.rotation_C = forward().transpose() * rate(t - 0.025 - late_s) * 0.05 + 0.001 * noise;
    check.add(turn);
  }
  return check.findings(forward(), given_s);
}

TEST(TurningCheck, FindsTheClocksOffset) {
  EXPECT_EQ(seriousKinds(offsetFound(0.05, 0)), Kinds{"time_offset"});
  EXPECT_EQ(seriousKinds(offsetFound(-0.03, 0)), Kinds{"time_offset"});
  EXPECT_EQ(seriousKinds(offsetFound(0.05, -0.05)), Kinds{});  // as given
  EXPECT_EQ(seriousKinds(offsetFound(0, 0)), Kinds{});
  EXPECT_EQ(seriousKinds(offsetFound(0, 0.02)), Kinds{"time_offset"});  // given, but not there
  const std::vector<Finding> f = offsetFound(0.05, 0);
  EXPECT_NE(f[0].evidence.find("-5"), std::string::npos) << f[0].evidence;  // -50 ms, or near
}

/// Stamps of the IMU that run fast, or those of the images; both begin together. In order of
/// stamps.
std::vector<Finding> clocksFound(double imu_rate, double image_rate, double offset_s = 0,
                                 int readings = 6000, double quick = 1) {
  TurningCheck check("IMU0", "CAM0");
  Random random(3);
  const auto stamp = [](double t, double clock) { return kDate + fromSeconds(t * clock); };
  int next = 60;
  for (int i = 0; i < readings; ++i) {
    const double t = 0.005 * i;
    const TimeNs at = stamp(t, imu_rate) + fromSeconds(offset_s);
    for (; next < readings && stamp(0.005 * next, image_rate) <= at; next += 10) {
      const double seen = 0.005 * next;
      ImageTurn turn;
      turn.t0 = stamp(seen - 0.05, image_rate);
      turn.t1 = stamp(seen, image_rate);
      const Vec3 noise(random.normal(), random.normal(), random.normal());
      turn.rotation_C = forward().transpose() * rate(quick * (seen - 0.025)) * 0.05 + 0.001 * noise;
      check.add(turn);
    }
    check.add(ImuSample{at, rate(quick * t), Vec3(0, 0, 9.81)});
  }
  return check.findings(forward(), 0);
}

TEST(TurningCheck, TellsAClockThatRunsFastFromOneThatIsOff) {
  struct Case {
    double imu, images;
    const char *stream, *said;
  };
  for (const Case& c : {Case{1.02, 1, "IMU0", " % fast against that of the images"},
                        Case{1.002, 1, "IMU0", " % fast against that of the images"},
                        Case{1, 1.02, "CAM0", " % fast against that of the IMU"},
                        Case{1, 0.995, "CAM0", " % slow against that of the IMU"}}) {
    const auto findings = clocksFound(c.imu, c.images);
    ASSERT_EQ(seriousKinds(findings), Kinds{"clock_rate"}) << c.imu << " " << c.images;
    EXPECT_EQ(findings[0].stream, c.stream) << findings[0].what;
    EXPECT_NE(findings[0].what.find(c.said), std::string::npos) << findings[0].what;
    // To a tenth of it.
    const double percent = std::stod(findings[0].what.substr(findings[0].what.find("runs") + 5));
    const double truth = 100 * std::abs(c.imu / c.images - 1);
    EXPECT_NEAR(percent, truth, 0.1 * truth) << findings[0].what;
  }
  EXPECT_EQ(seriousKinds(clocksFound(1, 1, 0.03)), Kinds{"time_offset"});
  // Of 8 s as well, as a hand turns.
  EXPECT_EQ(seriousKinds(clocksFound(0.97, 1, 0, 1600, 3)), Kinds{"clock_rate"});
  EXPECT_EQ(seriousKinds(clocksFound(1, 1.01, 0, 1600, 3)), Kinds{"clock_rate"});
  EXPECT_EQ(seriousKinds(clocksFound(1, 1, 0.03, 1600, 3)), Kinds{"time_offset"});
  EXPECT_EQ(seriousKinds(clocksFound(1, 1, 0, 1600, 3)), Kinds{});
  // Slow and smooth: no piece tells an offset from a bias, all of them together tell the rate.
  for (const double images : {1.01, 0.98, 1.03}) {
    for (const int readings : {1600, 3000}) {
      if (readings == 1600 && images < 1.03) continue;  // not always told by 8 s
      const auto findings = clocksFound(1, images, 0, readings);
      EXPECT_EQ(seriousKinds(findings), Kinds{"clock_rate"}) << images << " " << readings;
      if (findings[0].kind != "clock_rate") continue;
      EXPECT_NE(findings[0].evidence.find("all turns together"), std::string::npos);
      const double percent = std::stod(findings[0].what.substr(findings[0].what.find("runs") + 5));
      EXPECT_NEAR(percent, 100 * std::abs(images - 1), 0.15) << findings[0].what;
    }
  }
  EXPECT_EQ(seriousKinds(clocksFound(1, 1, 0, 1600)), Kinds{});
  // As quartz differs.
  EXPECT_EQ(seriousKinds(clocksFound(1.00005, 1)), Kinds{});
}

/// A constant is no scale, no lens and no other axis.
TEST(TurningCheck, TellsABiasFromAScale) {
  for (const Vec3& bias : {Vec3(0.2, 0, 0), Vec3(0, -0.2, 0), Vec3(0, 0, 0.2)}) {
    const auto findings =
        findingsOf([&](const Vec3& w) { return Vec3(w + bias); }, forward(), forward());
    ASSERT_EQ(seriousKinds(findings), Kinds{"gyro_bias"});
    EXPECT_EQ(findings.back().stream, "IMU0");
  }
  const Vec3 small(0.08, 0, 0);
  const auto slight =
      findingsOf([&](const Vec3& w) { return Vec3(w + small); }, forward(), forward());
  EXPECT_EQ(seriousKinds(slight), Kinds{});
  EXPECT_EQ(slight.back().kind, "gyro_bias");
  EXPECT_NE(slight.back().what.find("(0.08"), std::string::npos) << slight.back().what;
  const auto both = findingsOf([](const Vec3& w) { return Vec3(1.3 * w + Vec3(0.2, 0, 0)); },
                               forward(), forward());
  EXPECT_EQ(seriousKinds(both), (Kinds{"camera_scale", "gyro_bias"}));
  // Neither does it hide what is wrong, or make it another fault.
  const Vec3 large(0.1, 0.1, 0);
  EXPECT_EQ(seriousKinds(
                findingsOf([&](const Vec3& w) { return Vec3(large - w); }, forward(), forward())),
            Kinds{"gyro_mirrored"});
  EXPECT_EQ(seriousKinds(findingsOf([&](const Vec3& w) { return Vec3(w + large); }, forward(),
                                    forward().transpose())),
            Kinds{"camera_pose_inverted"});
}

TEST(TurningCheck, NamesDegrees) {
  const auto degrees = [](const Vec3& w) { return Vec3(57.3 * w); };
  EXPECT_EQ(seriousKinds(findingsOf(degrees, forward(), forward())), Kinds{"gyro_in_deg"});
  const auto milli = [](const Vec3& w) { return Vec3(57300 * w); };
  EXPECT_EQ(seriousKinds(findingsOf(milli, forward(), forward())), Kinds{"gyro_in_mdeg"});
  const auto twice = [](const Vec3& w) { return Vec3(3 * w); };
  EXPECT_EQ(seriousKinds(findingsOf(twice, forward(), forward())), Kinds{"gyro_scale"});
}

TEST(TurningCheck, NamesAPoseGivenTheWrongWayRound) {
  EXPECT_EQ(seriousKinds(findingsOf(kAsItIs, forward(), forward().transpose())),
            Kinds{"camera_pose_inverted"});
}

/// Half a turn between the rotation given and the true one, by the axis of the camera.
TEST(TurningCheck, NamesTheCauseOfHalfATurn) {
  const auto given = [](double x, double y, double z) {
    return Mat3(forward() * expSO3(kPi * Vec3(x, y, z).normalized()));
  };
  EXPECT_EQ(seriousKinds(findingsOf(kAsItIs, forward(), given(0, 0, 1))),
            Kinds{"camera_upside_down"});
  for (const Mat3& told : {given(1, 0, 0), given(0, 1, 0), given(1, 1, 0), given(1, -1, 0)}) {
    const auto findings = findingsOf(kAsItIs, forward(), told);
    // Without matches nothing tells a mirror from a camera that looks back: both are said.
    ASSERT_EQ(seriousKinds(findings), Kinds{"images_mirrored"});
    EXPECT_NE(findings.back().what.find("the other way"), std::string::npos)
        << findings.back().what;
  }
}

TEST(TurningCheck, NamesALensThatDoesNotFit) {
  const auto faster = [](const Vec3& w) { return Vec3(1.3 * w); };
  const auto findings = findingsOf(faster, forward(), forward());
  ASSERT_EQ(seriousKinds(findings), Kinds{"camera_scale"});
  EXPECT_EQ(findings[0].stream, "CAM0");
  EXPECT_NE(findings[0].what.find("lens model"), std::string::npos);
}

TEST(TurningCheck, NamesANegatedGyro) {
  const auto negated = [](const Vec3& w) { return Vec3(-w); };
  const auto findings = findingsOf(negated, forward(), forward());
  ASSERT_EQ(seriousKinds(findings), Kinds{"gyro_mirrored"});
  EXPECT_NE(findings[0].what.find("negated"), std::string::npos) << findings[0].what;
}

/// Turning about one axis alone tells that a pose is wrong, but not which would be right.
TEST(TurningCheck, DoubtsAPoseThatOneAxisSpeaksAgainst) {
  const Vec3 up(0, 0, 1);
  TurningCheck check("IMU0", "CAM0");
  for (int i = 0; i < 4000; ++i) {
    const double t = 0.005 * i;
    const auto about = [&](double at) { return Vec3(0.8 * std::sin(0.9 * at) * up); };
    if (i % 10 == 5 && i > 10) {
      ImageTurn turn;
      turn.t0 = fromSeconds(t - 0.05);
      turn.t1 = fromSeconds(t);
      turn.rotation_C = forward().transpose() * about(t - 0.025) * 0.05;
      check.add(turn);
    }
    check.add(ImuSample{fromSeconds(t), about(t), Vec3(0, 0, 9.81)});
  }
  EXPECT_EQ(seriousKinds(check.findings(forward(), 0)), Kinds{});
  const Mat3 over = forward() * Vec3(-1, -1, 1).asDiagonal();
  EXPECT_EQ(seriousKinds(check.findings(over, 0)), Kinds{"turns_otherwise"});
  EXPECT_FALSE(check.verdict(over, 0).R_B_C);
}

TEST(TurningCheck, NamesExchangedAxes) {
  const auto turned = [](const Vec3& w) { return Vec3(w.y(), -w.x(), w.z()); };
  const auto findings = findingsOf(turned, forward(), forward());
  ASSERT_EQ(seriousKinds(findings), Kinds{"camera_rotation"});
  EXPECT_NE(findings[0].what.find("x is -y, y is x, z is z"), std::string::npos)
      << findings[0].what;
  const auto mirrored = [](const Vec3& w) { return Vec3(w.x(), -w.y(), w.z()); };
  EXPECT_EQ(seriousKinds(findingsOf(mirrored, forward(), forward())), Kinds{"gyro_mirrored"});
}

TEST(TurningCheck, NamesWhatDoesNotBelongTogether) {
  Random random(9);
  const auto other = [&](const Vec3& w) {
    return Vec3(w.norm() * Vec3(random.normal(), random.normal(), random.normal()).normalized());
  };
  // Averaged over an image there is little left of it.
  EXPECT_FALSE(seriousKinds(findingsOf(other, forward(), forward())).empty());
}

/// A far wall that a camera pans over.
TEST(ImageTurning, FindsTheTurningOfAPan) {
  CameraCalibration c;
  c.width = 376;
  c.height = 240;
  c.fx = c.fy = 230;
  c.cx = 188;
  c.cy = 120;
  ImageTurning turning(camera::makeCamera(c));
  cv::Mat wall(600, 1200, CV_8UC1);
  cv::theRNG().state = 5;
  cv::randu(wall, 0, 255);
  cv::GaussianBlur(wall, wall, {0, 0}, 3);
  cv::normalize(wall, wall, 0, 255, cv::NORM_MINMAX);
  const auto view = [&](double yaw) {
    // Pixel of the view to pixel of the wall, by way of the direction.
    const Mat3 R = expSO3(Vec3(0, yaw, 0));
    cv::Mat x(c.height, c.width, CV_32F), y(c.height, c.width, CV_32F), out;
    for (int v = 0; v < c.height; ++v) {
      for (int u = 0; u < c.width; ++u) {
        const Vec3 d = R * Vec3((u - c.cx) / c.fx, (v - c.cy) / c.fy, 1);
        x.at<float>(v, u) = static_cast<float>(600 + 300 * d.x() / d.z());
        y.at<float>(v, u) = static_cast<float>(300 + 300 * d.y() / d.z());
      }
    }
    cv::remap(wall, out, x, y, cv::INTER_LINEAR);
    return out;
  };
  EXPECT_FALSE(turning.add(0, view(0)).has_value());
  const auto turn = turning.add(50000000, view(0.03));
  ASSERT_TRUE(turn.has_value());
  EXPECT_LT((turn->rotation_C - Vec3(0, 0.03, 0)).norm(), 0.006) << turn->rotation_C.transpose();
  EXPECT_EQ(turn->t1, 50000000);
  EXPECT_FALSE(turning.add(1, cv::Mat(10, 10, CV_8UC1)).has_value());
}

}  // namespace
}  // namespace vir::check
