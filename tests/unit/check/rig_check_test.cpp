/// Two cameras that look at the same: rendered pairs of a room, and calibrations that do not fit.
#include "vir/check/rig_check.h"

#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "found.h"
#include "vir/core/angles.h"
#include "vir/rendering/camera_simulator.h"
#include "vir/rendering/make_scene.h"

namespace vir::check {
namespace {

constexpr double kBaseline_m = 0.11;
constexpr int kInstants = 12;

CameraCalibration lens() {
  CameraCalibration c;
  c.width = 480;
  c.height = 320;
  c.fx = c.fy = 290;
  c.cx = 236;
  c.cy = 158;
  c.distortion = Distortion::radtan;
  c.dist = {-0.28, 0.07, 0.0002, 0, 0};
  return c;
}

CameraCalibration pinhole() {
  CameraCalibration c = lens();
  c.distortion = Distortion::none;
  c.dist.fill(0);
  return c;
}

Pose firstMount() {
  Mat3 forward;
  forward << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return {Quat(forward), Vec3(0.05, 0.02, -0.01)};
}

/// Another one of the kind.
CameraCalibration secondLens() {
  CameraCalibration c = lens();
  c.fx = c.fy = 270;
  c.cx = 260;
  return c;
}

/// Of the second camera in the first, as it is: beside it and turned a little.
Pose trueBetween() { return {expQuat(Vec3(0.01, 0.02, -0.015)), Vec3(kBaseline_m, 0.002, 0.001)}; }

using Pair = std::array<cv::Mat, 2>;

using Lenses = std::array<CameraCalibration, 2>;

Lenses lenses() { return {lens(), lens()}; }

constexpr TimeNs kStep = 500'000'000;
TimeNs timeOf(std::size_t k) { return 1'000'000'000LL + kStep * static_cast<TimeNs>(k); }

/// The body after so many steps, on its way and on a slower one to a side.
Pose fastPose(double k) { return {Quat(rotZ(0.25 * k)), Vec3(0.4 * k, 0.1 * k, 1.0)}; }
Pose slowPose(double k) { return {Quat(rotZ(0.02 * k)), Vec3(0.02 * k, 0.12 * k, 1.0)}; }

/// What both see along a path; `T_0_1` of the second in the first.
std::vector<Pair> seen(const Lenses& calibrations, const Pose& T_0_1, double second_gain = 1,
                       Pose (*pose)(double) = fastPose) {
  std::vector<Vec3> path;
  for (int k = 0; k <= kInstants; ++k) path.push_back(pose(k).p);
  const auto scene = std::make_shared<rendering::Scene>(rendering::makeScene({}, path, {}));
  std::vector<Pair> out(kInstants);
  for (std::size_t c = 0; c < 2; ++c) {
    rendering::CameraSimulationOptions o;
    o.seed = 1 + static_cast<int>(c);
    o.exposure_s = 0;
    if (c == 1) o.exposure_jump = {0, second_gain};
    rendering::CameraSimulator simulator(o, scene, camera::makeCamera(calibrations[c]));
    for (std::size_t k = 0; k < kInstants; ++k) {
      const Pose T_W_C = pose(static_cast<double>(k)) * firstMount() * (c == 0 ? Pose() : T_0_1);
      const auto& image = simulator.take(1, k, [&](double) { return T_W_C; });
      out[k][c] = cv::Mat(image.height, image.width, CV_8UC1,
                          const_cast<std::uint8_t*>(image.pixels.data()))
                      .clone();
    }
  }
  return out;
}

std::vector<Pair> seenSlowly() { return seen(lenses(), trueBetween(), 1, slowPose); }

/// Rendered once.
const std::vector<Pair>& rawPairs() {
  static const std::vector<Pair> pairs = seen(lenses(), trueBetween());
  return pairs;
}

std::vector<Finding> findingsOf(const std::vector<Pair>& pairs, const Lenses& said,
                                const Pose& said_T_0_1, TimeNs apart = 0, bool swap = false) {
  RigCheck check({"CAM0", said[0], firstMount()}, {"CAM1", said[1], firstMount() * said_T_0_1});
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const TimeNs t = 1'000'000'000LL + 500'000'000LL * static_cast<TimeNs>(k);
    check.add(0, t, pairs[k][swap ? 1 : 0]);
    check.add(1, t + apart, pairs[k][swap ? 0 : 1]);
  }
  return check.findings();
}

TEST(RigCheck, ARightCalibrationIsConfirmed) {
  const auto found = findingsOf(rawPairs(), lenses(), trueBetween());
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].kind, "rig");
  EXPECT_EQ(found[0].severity, Severity::note);
  EXPECT_EQ(found[0].stream, "CAM1");
}

TEST(RigCheck, StampsThatAreALittleApartAreOneInstant) {
  const auto found = findingsOf(rawPairs(), lenses(), trueBetween(), 20'000'000);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].kind, "rig");
  EXPECT_TRUE(findingsOf(rawPairs(), lenses(), trueBetween(), 40'000'000).empty());
}

TEST(RigCheck, SwappedImagesAreNamed) {
  const auto found = findingsOf(rawPairs(), lenses(), trueBetween(), 0, true);
  EXPECT_EQ(seriousKinds(found), Kinds{"rig_swapped"});
}

TEST(RigCheck, AnInvertedPoseIsNamedWhereTheLensesDiffer) {
  const Lenses said{lens(), secondLens()};
  const auto pairs = seen(said, trueBetween());
  EXPECT_EQ(seriousKinds(findingsOf(pairs, said, trueBetween())), Kinds{});
  EXPECT_EQ(seriousKinds(findingsOf(pairs, said, trueBetween().inverse())), Kinds{"rig_inverted"});
  EXPECT_EQ(seriousKinds(findingsOf(pairs, said, trueBetween(), 0, true)), Kinds{"rig_swapped"});
}

/// Two of one kind: the images swapped, and the pose inverted, look the same.
TEST(RigCheck, OfLikeLensesBothCausesAreNamed) {
  const auto found = findingsOf(rawPairs(), lenses(), trueBetween().inverse());
  ASSERT_EQ(seriousKinds(found), Kinds{"rig_swapped"});
  EXPECT_NE(found[0].what.find("or the pose of CAM1 is the wrong way round"), std::string::npos);
}

TEST(RigCheck, RectifiedImagesWithTheRawCalibrationAreNamed) {
  const Pose side_by_side{Quat::Identity(), Vec3(kBaseline_m, 0, 0)};
  const auto pairs = seen({pinhole(), pinhole()}, side_by_side);
  EXPECT_EQ(seriousKinds(findingsOf(pairs, {pinhole(), pinhole()}, side_by_side)), Kinds{});
  EXPECT_EQ(seriousKinds(findingsOf(pairs, lenses(), trueBetween())), Kinds{"rig_rectified"});
}

TEST(RigCheck, AWrongMountIsMeasured) {
  const Pose off = trueBetween() * Pose{expQuat(Vec3(0, 0, 5 * kPi / 180)), Vec3::Zero()};
  const auto found = findingsOf(rawPairs(), lenses(), off);
  ASSERT_EQ(seriousKinds(found), Kinds{"rig_geometry"});
  EXPECT_NE(found[0].what.find("turned by another 4.99 deg"), std::string::npos) << found[0].what;
}

TEST(RigCheck, WhatAnEstimatorCorrectsIsANote) {
  const Pose off = trueBetween() * Pose{expQuat(Vec3(0.02, 0, 0)), Vec3::Zero()};
  const auto found = findingsOf(rawPairs(), lenses(), off);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].kind, "rig_geometry");
  EXPECT_EQ(found[0].severity, Severity::note);
}

TEST(RigCheck, AWayOfTheWrongSignIsNamed) {
  const Pose mirrored{trueBetween().q, -trueBetween().p};
  const auto found = findingsOf(rawPairs(), lenses(), mirrored);
  EXPECT_EQ(seriousKinds(found), Kinds{"rig_mirrored"});
  // Of what is far away all matches are near their line, and most behind the cameras.
  const Pose close{trueBetween().q, trueBetween().p / 10};
  const auto far = seen(lenses(), close);
  EXPECT_EQ(seriousKinds(findingsOf(far, lenses(), close)), Kinds{});
  EXPECT_EQ(seriousKinds(findingsOf(far, lenses(), {close.q, -close.p})), Kinds{"rig_mirrored"});
}

TEST(RigCheck, CamerasAtOnePlaceThatSeeOtherwiseAreNamed) {
  EXPECT_EQ(seriousKinds(findingsOf(rawPairs(), lenses(), Pose{trueBetween().q, Vec3::Zero()})),
            Kinds{"rig_same_place"});
  EXPECT_EQ(seriousKinds(findingsOf(rawPairs(), lenses(), Pose())), Kinds{"rig_same_place"});
}

/// T_BS the wrong way round: of the second camera, and of both (T_cam_imu of Kalibr taken as it
/// is).
TEST(RigCheck, APoseInTheBodyThatIsInvertedIsNamed) {
  const auto of = [](const Pose& T_B_0, const Pose& T_B_1) {
    RigCheck check({"CAM0", lens(), T_B_0}, {"CAM1", lens(), T_B_1});
    for (std::size_t k = 0; k < rawPairs().size(); ++k) {
      const TimeNs t = 1'000'000'000LL + 500'000'000LL * static_cast<TimeNs>(k);
      for (const int c : {0, 1}) check.add(c, t, rawPairs()[k][static_cast<std::size_t>(c)]);
    }
    return check.findings();
  };
  const Pose T_B_0 = firstMount(), T_B_1 = firstMount() * trueBetween();
  const auto second = of(T_B_0, T_B_1.inverse());
  ASSERT_EQ(seriousKinds(second), Kinds{"rig_inverted"});
  EXPECT_EQ(second[0].what, "the pose of CAM1 in the body is the wrong way round");
  const auto both = of(T_B_0.inverse(), T_B_1.inverse());
  ASSERT_EQ(seriousKinds(both), Kinds{"rig_inverted"});
  EXPECT_EQ(both[0].what, "the poses of CAM0 and CAM1 in the body are the wrong way round");
}

/// Depth by the pair against depth by the true path, on which the first camera moves.
TEST(RigCheck, ALengthThatIsWrongIsMeasuredByTheTruePath) {
  const std::vector<Pair> pairs = seenSlowly();
  const auto of = [&](double times, double of_path) {
    RigCheck check({"CAM0", lens(), firstMount()},
                   {"CAM1", lens(), firstMount() * Pose{trueBetween().q, times * trueBetween().p}});
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      for (const int c : {0, 1}) check.add(c, timeOf(k), pairs[k][static_cast<std::size_t>(c)]);
    }
    return check.findings([&](TimeNs t) -> std::optional<Pose> {
      if (of_path == 0) return std::nullopt;
      Pose T = slowPose(static_cast<double>(t - timeOf(0)) / static_cast<double>(kStep));
      T.p *= of_path;
      return T;
    });
  };
  EXPECT_EQ(seriousKinds(of(1, 1)), Kinds{});
  for (const double times : {0.7, 1.3}) {
    const auto found = of(times, 1);
    ASSERT_EQ(seriousKinds(found), Kinds{"rig_length"});
    EXPECT_EQ(found[0].stream, "CAM1");
    EXPECT_NEAR(std::stod(found[0].what.substr(6)), 1 / times, 0.06) << found[0].what;
  }
  // Without a path nobody knows, which is said.
  const auto unknown = of(1.3, 0);
  EXPECT_EQ(seriousKinds(unknown), Kinds{});
  ASSERT_EQ(unknown.size(), 1u);
  EXPECT_NE(unknown[0].evidence.find("cannot be judged without a true path"), std::string::npos);
}

TEST(RigCheck, CamerasThatLookElsewhereAreNotCompared) {
  const Pose behind{expQuat(Vec3(0, kPi, 0)), Vec3(0, 0, -0.1)};
  const auto found = findingsOf(seen(lenses(), behind), lenses(), behind);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].kind, "rig");
  EXPECT_NE(found[0].what.find("looks elsewhere"), std::string::npos);
}

/// As the inverse of T_BS has it.
TEST(RigCheck, ACalibrationByWhichTheyLookElsewhereIsContradictedByWhatTheySee) {
  const Pose aside{expQuat(Vec3(0, 2, 0)), Vec3(0, 0, -0.1)};
  EXPECT_EQ(seriousKinds(findingsOf(rawPairs(), lenses(), aside)), Kinds{"rig_geometry"});
}

TEST(RigCheck, APoseThatNothingExplainsIsNamed) {
  const Pose odd{expQuat(Vec3(0, 0, 2.2)), Vec3(0, 0.1, 0)};
  const auto found = findingsOf(rawPairs(), lenses(), odd);
  EXPECT_EQ(seriousKinds(found), Kinds{"rig_geometry"});
}

TEST(RigCheck, ACoveredCameraShowsNothing) {
  std::vector<Pair> pairs = rawPairs();
  for (Pair& p : pairs) p[1] = cv::Mat(p[1].rows, p[1].cols, CV_8UC1, cv::Scalar(3));
  EXPECT_EQ(seriousKinds(findingsOf(pairs, lenses(), trueBetween())), Kinds{"rig_no_matches"});
}

TEST(RigCheck, DifferentExposureIsSaid) {
  const auto found = findingsOf(seen(lenses(), trueBetween(), 0.4), lenses(), trueBetween());
  ASSERT_FALSE(found.empty());
  EXPECT_EQ(found[0].kind, "rig_exposure");
  EXPECT_EQ(seriousKinds(found), Kinds{});
}

TEST(RigCheck, NothingIsSaidOfAFewImagesOrNone) {
  const std::vector<Pair> few(rawPairs().begin(), rawPairs().begin() + 3);
  EXPECT_TRUE(findingsOf(few, lenses(), trueBetween().inverse()).empty());
  EXPECT_TRUE(findingsOf({}, lenses(), trueBetween()).empty());
  EXPECT_TRUE(findingsOf({{cv::Mat(), cv::Mat()}}, lenses(), trueBetween()).empty());
}

TEST(RigCheck, ACalibrationThatIsNoneIsRefused) {
  CameraCalibration none = lens();
  none.fx = 0;
  EXPECT_THROW(RigCheck({"CAM0", lens(), firstMount()}, {"CAM1", none, firstMount()}),
               std::invalid_argument);
}

}  // namespace
}  // namespace vir::check
