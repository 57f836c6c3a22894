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

/// What both see along a path; `T_0_1` of the second in the first.
std::vector<Pair> seen(const Lenses& calibrations, const Pose& T_0_1, double second_gain = 1) {
  std::vector<Vec3> path;
  for (int k = 0; k <= kInstants; ++k) path.emplace_back(0.4 * k, 0.1 * k, 1.0);
  const auto scene = std::make_shared<rendering::Scene>(rendering::makeScene({}, path, {}));
  std::vector<Pair> out(kInstants);
  for (std::size_t c = 0; c < 2; ++c) {
    rendering::CameraSimulationOptions o;
    o.seed = 1 + static_cast<int>(c);
    o.exposure_s = 0;
    if (c == 1) o.exposure_jump = {0, second_gain};
    rendering::CameraSimulator simulator(o, scene, camera::makeCamera(calibrations[c]));
    for (std::size_t k = 0; k < kInstants; ++k) {
      const Pose T_W_B{Quat(rotZ(0.25 * static_cast<double>(k))), path[k]};
      const Pose T_W_C = T_W_B * firstMount() * (c == 0 ? Pose() : T_0_1);
      const auto& image = simulator.take(1, k, [&](double) { return T_W_C; });
      out[k][c] = cv::Mat(image.height, image.width, CV_8UC1,
                          const_cast<std::uint8_t*>(image.pixels.data()))
                      .clone();
    }
  }
  return out;
}

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
