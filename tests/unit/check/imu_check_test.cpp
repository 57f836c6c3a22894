#include "vir/check/imu_check.h"

#include <gtest/gtest.h>

#include <cmath>

#include "found.h"
#include "vir/core/random.h"

namespace vir::check {
namespace {

/// Carried by hand for 20 s: it tilts, turns and is shaken, with up near (0.3, 0, 1).
std::vector<ImuSample> carried() {
  std::vector<ImuSample> out;
  Random random(3);
  for (int i = 0; i < 4000; ++i) {
    const double t = 0.005 * i;
    const Vec3 tilt(0.3 * std::sin(0.9 * t), 0.3 + 0.2 * std::cos(0.7 * t), 0);
    ImuSample s;
    s.t = 1400000000000000000 + i * 5000000LL;
    const double shake = std::fmod(t, 4) < 2 ? 1.5 : 0;
    s.acc = expSO3(tilt).transpose() * Vec3(0, 0, 9.81) +
            shake * Vec3(std::sin(9 * t), std::cos(11 * t), std::sin(13 * t)) +
            0.02 * Vec3(random.normal(), random.normal(), random.normal());
    s.gyro = Vec3(0.27 * std::cos(0.9 * t), -0.14 * std::sin(0.7 * t), 0.8 * std::sin(0.5 * t)) +
             0.002 * Vec3(random.normal(), random.normal(), random.normal());
    out.push_back(s);
  }
  return out;
}

template <typename Change>
std::vector<Finding> findingsAfter(Change change,
                                   const std::optional<Mounting>& mounting = std::nullopt) {
  ImuCheck check("IMU0");
  for (ImuSample s : carried()) {
    change(&s);
    check.add(s);
  }
  return check.findings(std::nullopt, mounting);
}

TEST(ImuCheck, NothingIsWrongWithSiUnits) {
  const auto findings = findingsAfter([](ImuSample*) {});
  EXPECT_EQ(seriousKinds(findings), Kinds{});
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].kind, "imu_noise");
}

TEST(ImuCheck, NamesUnits) {
  const auto kinds = [](auto change) { return seriousKinds(findingsAfter(change)); };
  EXPECT_EQ(kinds([](ImuSample* s) { s->acc /= 9.80665; }), Kinds{"acc_in_g"});
  EXPECT_EQ(kinds([](ImuSample* s) { s->acc *= 1000 / 9.80665; }), Kinds{"acc_in_mg"});
  EXPECT_EQ(kinds([](ImuSample* s) { s->gyro *= 57.2958; }), Kinds{"gyro_in_deg"});
  EXPECT_EQ(kinds([](ImuSample* s) { s->acc *= 1.6; }), Kinds{"acc_scale"});
  EXPECT_EQ(kinds([](ImuSample* s) { s->acc *= 16384 / 9.80665; }), Kinds{"acc_scale"});
  EXPECT_EQ(kinds([](ImuSample* s) { s->acc *= 0.05; }), Kinds{"gravity_removed"});
}

TEST(ImuCheck, NamesSwappedColumns) {
  EXPECT_EQ(seriousKinds(findingsAfter([](ImuSample* s) { std::swap(s->acc, s->gyro); })),
            Kinds{"imu_columns_swapped"});
}

TEST(ImuCheck, NamesANegatedAccelerometerByTheCamera) {
  Mounting forward;  // camera z = body x, camera y = -body z
  forward.R_B_C << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  forward.camera = "CAM0";
  EXPECT_EQ(seriousKinds(findingsAfter([](ImuSample*) {}, forward)), Kinds{});
  const auto findings = findingsAfter([](ImuSample* s) { s->acc = -s->acc; }, forward);
  EXPECT_EQ(seriousKinds(findings), Kinds{"acc_negated"});
  EXPECT_EQ(findings[0].severity, Severity::doubtful);
  Mounting down;  // camera z = -body z
  down.R_B_C << 0, -1, 0, -1, 0, 0, 0, 0, -1;
  EXPECT_EQ(seriousKinds(findingsAfter([](ImuSample*) {}, down)), Kinds{});
  EXPECT_EQ(seriousKinds(findingsAfter([](ImuSample* s) { s->acc = -s->acc; }, down)),
            Kinds{"acc_negated"});
}

TEST(ImuCheck, SeesTheNoiseAndHoldsItAgainstWhatIsGiven) {
  ImuCheck check("IMU0");
  for (const ImuSample& s : carried()) check.add(s);
  imu::ImuNoise given;
  given.gyro_noise_density = 1e-7;
  given.acc_noise_density = 1e-3;
  EXPECT_EQ(seriousKinds(check.findings(given, std::nullopt)), Kinds{"imu_noise"});
  // sigma 0.002 rad/s at 200 Hz
  given.gyro_noise_density = 0.002 * std::sqrt(0.005);
  EXPECT_EQ(seriousKinds(check.findings(given, std::nullopt)), Kinds{});
}

TEST(ImuCheck, TooLittleSaysNothingAndNaNDoesNotHarm) {
  ImuCheck check("IMU0");
  EXPECT_TRUE(check.findings(std::nullopt, std::nullopt).empty());
  ImuSample s;
  s.acc.setConstant(NAN);
  check.add(s);
  EXPECT_EQ(check.findings(std::nullopt, std::nullopt).size(), 1u);
}

}  // namespace
}  // namespace vir::check
