#include "vir/check/imu_check.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "found.h"
#include "vir/core/random.h"
#include "vir_test_noise.h"

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

/// Tumbles, with gravity as it is then.
ImuSample turning(TimeNs t) {
  ImuSample s;
  s.t = t;
  const double seconds = toSeconds(t - 1400000000000000000);
  // About an axis that stays, so that the attitude is known.
  const Vec3 axis = Vec3(1, 2, 3).normalized();
  s.gyro = 0.6 * axis;
  s.acc = expSO3(0.6 * seconds * axis).transpose() * Vec3(0, 9.81, 0);
  return s;
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
  EXPECT_EQ(kinds([](ImuSample* s) { s->acc *= 100; }), Kinds{"acc_in_cm"});
  EXPECT_EQ(kinds([](ImuSample* s) { s->gyro *= 57.2958; }), Kinds{"gyro_in_deg"});
  EXPECT_EQ(kinds([](ImuSample* s) { s->acc *= 1.6; }), Kinds{"acc_scale"});
  EXPECT_EQ(kinds([](ImuSample* s) { s->acc *= 16384 / 9.80665; }), Kinds{"acc_scale"});
  EXPECT_EQ(kinds([](ImuSample* s) { s->acc *= 0.05; }), Kinds{"gravity_removed"});
}

TEST(ImuCheck, NamesMillidegrees) {
  const auto findings = findingsAfter([](ImuSample* s) { s->gyro *= 57295.8; });
  ASSERT_EQ(seriousKinds(findings), Kinds{"gyro_scale"});
  EXPECT_NE(findings[0].what.find("mdeg/s"), std::string::npos) << findings[0].what;
}

/// At one end or both, one axis or more; what is just coarse, or says two numbers only, is not.
TEST(ImuCheck, NamesClippedReadings) {
  const auto both =
      findingsAfter([](ImuSample* s) { s->gyro.z() = std::clamp(s->gyro.z(), -0.6, 0.6); });
  ASSERT_EQ(seriousKinds(both), Kinds{"gyro_clipped"});
  EXPECT_NE(both[0].what.find("z at +-0.6 rad/s"), std::string::npos) << both[0].what;
  EXPECT_EQ(both[0].what.find('x'), std::string::npos) << both[0].what;
  const auto above = findingsAfter([](ImuSample* s) { s->gyro.z() = std::min(s->gyro.z(), 0.5); });
  ASSERT_EQ(seriousKinds(above), Kinds{"gyro_clipped"});
  EXPECT_NE(above[0].what.find("z at 0.5 rad/s"), std::string::npos) << above[0].what;
  // Below gravity: not a wrong scale.
  const auto force = findingsAfter([](ImuSample* s) { s->acc = s->acc.cwiseMin(7.5); });
  ASSERT_EQ(seriousKinds(force), Kinds{"acc_clipped"});
  EXPECT_NE(force[0].what.find("z at 7.5 m/s^2"), std::string::npos) << force[0].what;
}

TEST(ImuCheck, CoarseNumbersAreNotClipped) {
  for (const double step : {0.01, 0.1, 0.4}) {
    const auto findings = findingsAfter([step](ImuSample* s) {
      s->gyro = (s->gyro / step).array().round() * step;
      s->acc = (s->acc / step).array().round() * step;
    });
    EXPECT_EQ(seriousKinds(findings), Kinds{}) << step;
  }
  // Without noise: it stands, or turns at one rate.
  const auto steps = findingsAfter([](ImuSample* s) { s->gyro = Vec3(0, 0, s->gyro.z() > 0); });
  EXPECT_EQ(std::count_if(steps.begin(), steps.end(),
                          [](const Finding& f) { return f.kind == "gyro_clipped"; }),
            0);
}

TEST(ImuCheck, NamesReadingsThatAreThereTwice) {
  for (const TimeNs later : {0LL, 2500000LL, 1000LL}) {
    ImuCheck check("IMU0");
    for (ImuSample s : carried()) {
      check.add(s);
      s.t += later;
      check.add(s);
    }
    const auto copies = check.copies();
    ASSERT_TRUE(copies) << later;
    EXPECT_EQ(copies->severity, Severity::doubtful);
    EXPECT_EQ(copies->what, "each reading is there twice");
    EXPECT_NE(copies->evidence.find(later == 0 ? "the same stamp" : "other stamps"),
              std::string::npos)
        << copies->evidence;
  }
  ImuCheck once("IMU0"), still("IMU0");
  for (const ImuSample& s : carried()) {
    once.add(s);
    ImuSample at_rest = s;
    if (toSeconds(s.t - 1400000000000000000) < 10) at_rest.acc = at_rest.gyro = Vec3(0, 0, 9);
    still.add(at_rest);
  }
  EXPECT_FALSE(once.copies());
  EXPECT_FALSE(still.copies());
}

TEST(ImuCheck, NamesASensorThatHangs) {
  const auto stuck = [](double seconds, const Vec3& gyro) {
    ImuCheck check("IMU0");
    const TimeNs first = carried().front().t;
    for (ImuSample s : carried()) {
      const double t = toSeconds(s.t - first);
      if (t > 3 && t < 3 + seconds) s = {s.t, gyro, Vec3(0.3, 0.1, 9.7)};
      check.add(s);
    }
    return check.stuck();
  };
  const Vec3 turns(0.2, -0.1, 0.3);
  const auto found = stuck(1.5, turns);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->severity, Severity::unusable);
  EXPECT_EQ(found->kind, "imu_stuck");
  EXPECT_NE(found->what.find("for 1.49 s"), std::string::npos) << found->what;
  EXPECT_NE(found->evidence.find("from 3"), std::string::npos) << found->evidence;
  EXPECT_FALSE(stuck(0.3, turns));
  EXPECT_FALSE(stuck(0, turns));
  EXPECT_TRUE(stuck(5, Vec3::Zero())) << "other readings have noise";
}

TEST(ImuCheck, NamesASensorThatHangsAtRestToo) {
  test::Noise noise(3);
  const auto stuck = [&](double from, double to, double step) {
    ImuCheck check("IMU0");
    for (int k = 0; k < 4000; ++k) {
      const double t = k / 200.0;
      ImuSample s{fromSeconds(10 + t), Vec3(0.01, 0, 0), Vec3(0, 0, 9.81)};
      if (t < from || t > to) {
        for (int i = 0; i < 3; ++i) {
          s.gyro[i] += 0.002 * noise.normal();
          s.acc[i] += 0.02 * noise.normal();
        }
      }
      for (int i = 0; i < 3 && step > 0; ++i) {
        s.gyro[i] = step * std::round(s.gyro[i] / step);
        s.acc[i] = 10 * step * std::round(s.acc[i] / (10 * step));
      }
      check.add(s);
    }
    return check.stuck();
  };
  EXPECT_TRUE(stuck(8, 12, 0));
  EXPECT_TRUE(stuck(2, 100, 0)) << "to the end";
  EXPECT_FALSE(stuck(8, 8.3, 0));
  EXPECT_FALSE(stuck(100, 100, 0));
  EXPECT_FALSE(stuck(100, 100, 0.02)) << "a coarse sensor at rest says the same for long";
  EXPECT_FALSE(stuck(0, 100, 0)) << "rest without noise";
}

TEST(ImuCheck, TellsMotionFromNoise) {
  ImuCheck check("IMU0");
  Random random(4);
  for (int i = 0; i < 2000; ++i) {
    const double t = 0.005 * i;
    ImuSample s;
    s.t = fromSeconds(t);
    s.gyro = Vec3(0.1, 0.1, t > 5 ? 0.2 * std::sin(t) : 0) + Vec3::Constant(0.01 * random.normal());
    s.acc = Vec3(0, 0, 9.81) + Vec3::Constant(0.3 * random.normal());
    check.add(s);
  }
  EXPECT_EQ(check.moves(fromSeconds(1), fromSeconds(4)), false);
  EXPECT_EQ(check.moves(fromSeconds(6), fromSeconds(9)), true);
  EXPECT_EQ(check.moves(fromSeconds(20), fromSeconds(30)), std::nullopt);
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

/// With the images' word there is no doubt left.
TEST(ImuCheck, TheImagesTellANegatedAccelerometerFromACameraUpsideDown) {
  Mounting forward;
  forward.R_B_C << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  forward.camera = "CAM0";
  forward.force.against = 9;
  const auto negate = [](ImuSample* s) { s->acc = -s->acc; };
  const auto negated = findingsAfter(negate, forward);
  ASSERT_EQ(seriousKinds(negated), Kinds{"acc_negated"});
  EXPECT_EQ(negated[0].severity, Severity::unusable);
  Mounting over = forward;
  over.R_B_C = forward.R_B_C * Vec3(-1, -1, 1).asDiagonal();
  over.force = {9, 1};
  const auto fine = findingsAfter([](ImuSample*) {}, over);
  EXPECT_EQ(seriousKinds(fine), Kinds{});
  ASSERT_FALSE(fine.empty());
  EXPECT_EQ(fine[0].kind, "camera_upside_down");
}

TEST(ImuCheck, NamesAxesOfTheAccelerometerThatAreNotTheGyros) {
  const auto upright = [](ImuSample* s) { *s = turning(s->t); };
  EXPECT_EQ(seriousKinds(findingsAfter(upright)), Kinds{});
  const auto exchanged = [](ImuSample* s) {
    *s = turning(s->t);
    std::swap(s->acc.x(), s->acc.y());
  };
  EXPECT_EQ(seriousKinds(findingsAfter(exchanged)), Kinds{"acc_axes"});
  const auto one = [](ImuSample* s) {
    *s = turning(s->t);
    s->acc.z() = -s->acc.z();
  };
  EXPECT_EQ(seriousKinds(findingsAfter(one)), Kinds{"acc_axes"});
  // As good as the right one: only images tell.
  const auto all = [](ImuSample* s) {
    *s = turning(s->t);
    s->acc = -s->acc;
  };
  EXPECT_EQ(seriousKinds(findingsAfter(all)), Kinds{});
}

/// Which turns gravity on, too.
TEST(ImuCheck, ABiasThatIsKnownIsNoWrongAxis) {
  ImuCheck check("IMU0");
  const Vec3 bias(0.3, -0.3, 0);
  for (ImuSample s : carried()) {
    s = turning(s.t);
    s.gyro += bias;
    check.add(s);
  }
  EXPECT_EQ(seriousKinds(check.findings(std::nullopt, std::nullopt)), Kinds{"acc_axes"});
  EXPECT_EQ(seriousKinds(check.findings(std::nullopt, std::nullopt, true, bias)), Kinds{});
}

/// One reading in thousands, as a bit error makes it, is said and spoils nothing else.
TEST(ImuCheck, NamesSingleReadingsThatJump) {
  // Within a quarter of a second, and at either end of it.
  for (const auto& [size, at] : std::vector<std::pair<double, int>>{
           {20, 1010}, {1e18, 1010}, {20, 1000}, {1e18, 999}, {20, 1001}, {20, 998}}) {
    ImuCheck check("IMU0");
    int i = 0;
    for (ImuSample s : carried()) {
      if (i++ == at) (size > 100 ? s.acc : s.gyro).x() += size;
      check.add(s);
    }
    const auto findings = check.findings(std::nullopt, std::nullopt);
    EXPECT_EQ(seriousKinds(findings), Kinds{"imu_spikes"}) << size << " " << at;
    EXPECT_EQ(findings[0].evidence.rfind("1 of 4000", 0), 0u) << findings[0].evidence;
  }
}

/// What is left of a hand's or drone's force without gravity is about 1 m/s^2, and is no unit.
TEST(ImuCheck, GravityRemovedIsNotTakenForG) {
  const auto removed = [](ImuSample* s) {
    const double t = toSeconds(s->t - 1400000000000000000);
    s->acc = Vec3(1.4 * std::sin(0.9 * t), 0.8 * std::cos(0.5 * t) * std::sin(1.3 * t), 0.1);
  };
  EXPECT_EQ(seriousKinds(findingsAfter(removed)), Kinds{"gravity_removed"});
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
