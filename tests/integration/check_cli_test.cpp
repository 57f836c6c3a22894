/// `vir-slam check` names what is wrong with a recording, and finds nothing wrong with good ones.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <sstream>

#include "vir_test_data.h"
#include "vir_test_shell.h"
#include "vir_test_variant.h"

namespace {

namespace fs = std::filesystem;
using vir::test::check;
using vir::test::Checked;
using vir::test::has;
using vir::test::quoted;
using vir::test::Row;
using vir::test::Variant;
using vir::test::virSlam;

/// Of a recording, from its first image on.
constexpr double kFewSeconds = 6;

constexpr const char* kFlight = "euroc_MH01_clip30s";
constexpr const char* kRoom = "rendered_V102_32s";

TEST(CheckCli, NothingIsWrongWithGoodRecordings) {
  for (const char* name : {kFlight, kRoom}) {
    VIR_REQUIRE_DATA(source, name);
    const auto o = virSlam("check " + quoted(source.string()));
    EXPECT_EQ(o.code, 0) << o.text;
    EXPECT_TRUE(vir::test::contains(o.text, "fine")) << o.text;
  }
}

TEST(CheckCli, NamesUnitsAxesAndColumns) {
  struct Case {
    const char* kind;
    int code;
    std::function<void(std::vector<double>*)> change;
  };
  const auto each = [](int from, double factor) {
    return [=](std::vector<double>* v) {
      for (int i = from; i < from + 3; ++i) (*v)[static_cast<std::size_t>(i)] *= factor;
    };
  };
  const std::vector<Case> cases{
      {"acc_in_g", 1, each(3, 1 / 9.80665)},
      {"acc_in_mg", 1, each(3, 1000 / 9.80665)},
      {"acc_negated", 1, each(3, -1)},
      {"acc_axes", 3, [](std::vector<double>* v) { (*v)[3] = -(*v)[3]; }},
      {"gyro_in_deg", 1, each(0, 57.29577951)},
      {"imu_columns_swapped", 1,
       [](std::vector<double>* v) { std::rotate(v->begin(), v->begin() + 3, v->begin() + 6); }},
      {"gyro_mirrored", 1, [](std::vector<double>* v) { (*v)[0] = -(*v)[0]; }},
      {"camera_rotation", 1, [](std::vector<double>* v) {
         const std::vector<double> w = *v;
         *v = {w[1], -w[0], w[2], w[4], -w[3], w[5]};
       }}};
  for (const char* name : {kFlight, kRoom}) {
    VIR_REQUIRE_DATA(source, name);
    for (const Case& c : cases) {
      // The flight hardly turns while its images are looked at, and each look takes seconds.
      if (name == kFlight && std::string(c.kind) != "acc_in_g") continue;
      const Variant v(source);
      v.imu(c.change);
      const Checked o = check(v);
      EXPECT_EQ(o.code, c.code) << name << " " << c.kind << "\n" << o.text;
      EXPECT_TRUE(has(o, c.kind)) << name << " " << c.kind << "\n" << o.text;
    }
  }
}

TEST(CheckCli, NamesALimitABiasAndAClockThatRunsFast) {
  VIR_REQUIRE_DATA(source, kRoom);
  const Variant clipped(source);
  clipped.imu([](std::vector<double>* v) { (*v)[2] = std::clamp((*v)[2], -0.5, 0.5); });
  const Checked c = check(clipped);
  EXPECT_EQ(c.code, 3) << c.text;
  EXPECT_EQ(c.kinds, std::vector<std::string>{"gyro_clipped"}) << c.text;
  const Variant biased(source);
  biased.imu([](std::vector<double>* v) { (*v)[0] += 0.2; });
  const Checked b = check(biased);
  EXPECT_EQ(b.code, 3) << b.text;
  EXPECT_EQ(b.kinds, std::vector<std::string>{"gyro_bias"}) << b.text;
  const Variant fast(source);
  long long first = 0;
  fast.rewrite("imu0", "#timestamp [ns]", [&](const Row& r) {
    if (first == 0) first = r.t;
    return Variant::line(first + (r.t - first) * 51 / 50, r.rest);
  });
  const Checked f = check(fast);
  EXPECT_EQ(f.code, 3) << f.text;
  EXPECT_EQ(f.kinds, std::vector<std::string>{"clock_rate"}) << f.text;
}

/// Import says it as well, in a line.
TEST(CheckCli, ImportSaysItToo) {
  VIR_REQUIRE_DATA(source, kRoom);
  const Variant v(source, kFewSeconds);
  v.imu([](std::vector<double>* x) {
    for (int i = 3; i < 6; ++i) (*x)[static_cast<std::size_t>(i)] /= 9.80665;
  });
  const auto o = virSlam("import euroc " + v.folder() + " --out " + quoted(v.out("v.rawlog")));
  EXPECT_EQ(o.code, 0) << o.text;
  EXPECT_TRUE(vir::test::contains(o.text, "unusable: IMU0: the accelerometer is in g")) << o.text;
  const auto c = virSlam("check " + quoted(v.out("v.rawlog")));
  EXPECT_EQ(c.code, 1) << c.text;
}

/// A run whose result cannot be trusted looks at the images as well, and names the cause first.
/// What a run sees on its way cannot tell this one from a camera upside down.
TEST(CheckCli, ARunThatCannotBeTrustedNamesTheCause) {
  VIR_REQUIRE_DATA(source, kRoom);
  const Variant v(source);
  v.imu([](std::vector<double>* x) {
    for (std::size_t i = 3; i < 6; ++i) (*x)[i] = -(*x)[i];
  });
  const auto i = virSlam("import euroc " + v.folder() + " --out " + quoted(v.out("v.rawlog")));
  ASSERT_EQ(i.code, 0) << i.text;
  const auto r = virSlam("run " + quoted(std::string(vir::test::sourceDir()) + "/ini/euroc.ini") +
                         " --rawlog " + quoted(v.out("v.rawlog")) + " --out " + quoted(v.out("r")));
  const auto summary = nlohmann::json::parse(std::ifstream(v.out("r/summary.json")));
  EXPECT_NE(summary["verdict"], "good");
  ASSERT_FALSE(summary["doubts"].empty());
  EXPECT_TRUE(vir::test::contains(summary["doubts"][0].get<std::string>(), "is negated")) << r.text;
}

TEST(CheckCli, HeadersAndStampsInAnyUnitAreRead) {
  VIR_REQUIRE_DATA(source, kRoom);
  const Variant swapped(source, kFewSeconds);
  swapped.imu(
      [](std::vector<double>* v) { std::rotate(v->begin(), v->begin() + 3, v->begin() + 6); },
      "timestamp,ax,ay,az,gx,gy,gz");
  const Checked o = check(swapped);
  EXPECT_EQ(o.code, 0) << o.text;
  EXPECT_TRUE(vir::test::contains(o.text, "by its header")) << o.text;
  const std::vector<std::pair<std::string, std::function<std::string(long long)>>> units{
      {"in ms", [](long long t) { return std::to_string(t / 1000000); }},
      {"in us", [](long long t) { return std::to_string(t / 1000); }},
      {"in s", [](long long t) {
         char text[40];
         std::snprintf(text, sizeof text, "%lld.%09lld", t / 1000000000, t % 1000000000);
         return std::string(text);
       }}};
  for (const auto& [said, convert] : units) {
    const Variant v(source, kFewSeconds);
    // The header still says nanoseconds, as copied headers do.
    for (const char* sensor : {"cam0", "imu0", "uwb0"}) {
      v.rewrite(sensor, "#timestamp [ns]",
                [&convert = convert](const Row& r) { return convert(r.t) + r.rest; });
    }
    const Checked c = check(v);
    EXPECT_EQ(c.code, 0) << c.text;
    EXPECT_TRUE(vir::test::contains(c.text, "the stamps are " + said)) << c.text;
  }
}

TEST(CheckCli, NamesAClockSincePowerUp) {
  VIR_REQUIRE_DATA(source, kRoom);
  const Variant v(source, kFewSeconds);
  long long first = 0;
  v.rewrite("imu0", "#timestamp [ns]", [&](const Row& r) {
    if (first == 0) first = r.t;
    return Variant::line(r.t - first + 43847434001234, r.rest);
  });
  const Checked c = check(v);
  EXPECT_EQ(c.code, 1) << c.text;
  EXPECT_TRUE(has(c, "no_overlap")) << c.text;
  EXPECT_TRUE(vir::test::contains(c.text, "IMU0 counts from power-up, CAM0 is Unix time"))
      << c.text;
  // What it says to do is right to a few milliseconds here.
  const std::string option = "euroc.imu_time_offset_s=";
  const std::size_t at = c.text.find(option);
  ASSERT_NE(at, std::string::npos) << c.text;
  const std::string set = c.text.substr(at, c.text.find(' ', at) - at);
  EXPECT_EQ(has(check(v, "--set " + set), "no_overlap"), false) << set;
}

TEST(CheckCli, NamesRangesInMillimetresAndReadsNamesOfAnchors) {
  VIR_REQUIRE_DATA(source, kRoom);
  const Variant mm(source, kFewSeconds);
  mm.rewrite("uwb0", "#timestamp [ns],anchor_id,range [m]", [](const Row& r) {
    return Variant::line(r.t, std::vector<double>{r.v[0], std::floor(1000 * r.v[1])});
  });
  const Checked c = check(mm);
  EXPECT_EQ(c.code, 1) << c.text;
  EXPECT_TRUE(has(c, "ranges_in_mm")) << c.text;
  // A run does not use them, and says so.
  const auto run = virSlam("run " + mm.folder() + " --out " + quoted(mm.out("run")));
  EXPECT_EQ(run.code, 0) << run.text;
  const auto summary = nlohmann::json::parse(vir::test::readText(mm.out("run/summary.json")));
  EXPECT_EQ(summary["verdict"], "doubtful");
  EXPECT_TRUE(vir::test::contains(summary["doubts"].at(0), "ranges are in millimetres"));
  for (const char* id : {"0x84", "200A", "9412036502"}) {
    const Variant v(source, kFewSeconds);
    v.rewrite("uwb0", "#timestamp [ns],anchor_id,range [m]", [&](const Row& r) {
      return std::to_string(r.t) + "," + id + "," + std::to_string(r.v[1]);
    });
    const Checked named = check(v);
    EXPECT_EQ(named.code, 0) << id << named.text;
    EXPECT_TRUE(vir::test::contains(named.text, "UWB0")) << id << named.text;
  }
}

/// Kalibr's file of the room's camera, with this for T_cam_imu.
std::string camchain(const std::string& rows) {
  return "cam0:\n  T_cam_imu:\n" + rows +
         "  - [0.0, 0.0, 0.0, 1.0]\n  camera_model: pinhole\n"
         "  distortion_coeffs: [-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05]\n"
         "  distortion_model: radtan\n  intrinsics: [458.654, 457.296, 367.215, 248.375]\n"
         "  resolution: [752, 480]\n";
}

TEST(CheckCli, NamesTheCauseOfAWrongPoseOfTheCamera) {
  VIR_REQUIRE_DATA(source, kRoom);
  const std::vector<std::pair<const char*, std::string>> poses{
      // T_cam_imu where T_imu_cam is meant: EuRoC's T_BS under the other name.
      {"camera_pose_inverted",
       "  - [0.0148655429818, -0.999880929698, 0.00414029679422, -0.0216]\n"
       "  - [0.999557249008, 0.0149672133247, 0.025715529948, -0.0647]\n"
       "  - [-0.0257744366974, 0.00375618835797, 0.999660727178, 0.0098]\n"},
      // As if it hung upside down: the accelerometer is not to blame.
      {"camera_upside_down",
       "  - [-0.0148655429818, -0.999557249008, 0.0257744366974, -0.0652]\n"
       "  - [0.999880929698, -0.0149672133247, -0.00375618835797, 0.0207]\n"
       "  - [0.00414029679422, 0.025715529948, 0.999660727178, -0.0081]\n"},
      // For axes x right, y up, z back.
      {"camera_rotation",
       "  - [0.0148655429818, 0.999557249008, -0.0257744366974, 0.0652]\n"
       "  - [0.999880929698, -0.0149672133247, -0.00375618835797, 0.0207]\n"
       "  - [-0.00414029679422, -0.025715529948, -0.999660727178, 0.0081]\n"},
      // In millimetres.
      {"camera_pose_far",
       "  - [0.0148655429818, 0.999557249008, -0.0257744366974, 65.2]\n"
       "  - [-0.999880929698, 0.0149672133247, 0.00375618835797, -20.7]\n"
       "  - [0.00414029679422, 0.025715529948, 0.999660727178, -8.1]\n"}};
  for (const auto& [kind, rows] : poses) {
    const Variant v(source);
    const std::string calibration = v.out("camchain.yaml");
    vir::test::writeText(calibration, camchain(rows));
    const Checked c = check(v, "--calibration " + quoted(calibration));
    EXPECT_EQ(c.code, 1) << c.text;
    EXPECT_EQ(c.kinds, std::vector<std::string>{kind}) << c.text;
    if (kind != std::string("camera_pose_inverted")) continue;
    // Import knows by gravity that something is wrong, and asks the images what.
    const auto o = virSlam("import " + v.folder() + " --calibration " + quoted(calibration) +
                           " --out " + quoted(v.out("x.rawlog")));
    EXPECT_EQ(o.code, 0) << o.text;
    EXPECT_TRUE(vir::test::contains(o.text, "is given the wrong way round")) << o.text;
    EXPECT_TRUE(vir::test::contains(o.text, "give the inverse")) << o.text;
    EXPECT_FALSE(vir::test::contains(o.text, "the accelerometer is negated")) << o.text;
  }
}

TEST(CheckCli, NamesNumbersThatNoCameraHas) {
  VIR_REQUIRE_DATA(source, kRoom);
  const Variant v(source, kFewSeconds);
  std::string text = camchain(
      "  - [0.0148655429818, 0.999557249008, -0.0257744366974, 0.0652]\n"
      "  - [-0.999880929698, 0.0149672133247, 0.00375618835797, -0.0207]\n"
      "  - [0.00414029679422, 0.025715529948, 0.999660727178, -0.0081]\n");
  const std::string right = "458.654, 457.296, 367.215, 248.375";
  text.replace(text.find(right), right.size(), "0.61, 0.953, 0.488, 0.517");
  vir::test::writeText(v.out("camchain.yaml"), text);
  const std::string given = " --calibration " + quoted(v.out("camchain.yaml"));
  const Checked c = check(v, given);
  EXPECT_EQ(c.code, 1) << c.text;
  EXPECT_EQ(c.kinds, std::vector<std::string>{"camera_intrinsics"}) << c.text;
  const auto i = virSlam("import " + v.folder() + " --out " + quoted(v.out("v.rawlog")) + given);
  EXPECT_TRUE(vir::test::contains(i.text, "units of the image's width")) << i.text;
}

TEST(CheckCli, NamesWhatWasLeftOut) {
  VIR_REQUIRE_DATA(source, kRoom);
  const Variant v(source, kFewSeconds);
  v.rewrite("imu0", "#timestamp [ns]",
            [](const Row& r) { return Variant::line(r.t / 10000000 * 10000000, r.rest); });
  const Checked c = check(v);
  EXPECT_EQ(c.code, 3) << c.text;
  EXPECT_TRUE(has(c, "repeated")) << c.text;
  EXPECT_TRUE(vir::test::contains(c.text, "rounded to 10 ms?")) << c.text;
  const auto i = virSlam("import " + v.folder() + " --out " + quoted(v.out("v.rawlog")));
  EXPECT_TRUE(vir::test::contains(i.text, "50 % of its readings have the stamp")) << i.text;
}

TEST(CheckCli, WrongUse) {
  EXPECT_EQ(virSlam("check /nonexistent").code, 2);
  const vir::test::TempFolder folder;
  vir::test::writeText(folder / "x.rawlog", "nothing");
  EXPECT_EQ(virSlam("check " + quoted((folder / "x.rawlog").string())).code, 1);
  EXPECT_EQ(virSlam("check " + quoted((folder / "x.rawlog").string()) + " --calibration " +
                    quoted((folder / "none.yaml").string()))
                .code,
            2);
}

}  // namespace
