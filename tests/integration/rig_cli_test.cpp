/// Rendered rigs through the whole program. Measured when this was written (drive 12 m, seed 3):
/// one camera finds no scale, two 0.03 m.
#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>

#include "end_to_end.h"
#include "vir/formats/calibration_file.h"
#include "vir/results/calibration_yaml.h"
#include "vir_test_paths.h"

namespace vir {
namespace {

using test::quoted;

const char* const kAuto = "--set Estimator.other_cameras=auto";

/// A straight drive at constant speed, seen by two cameras of half EuRoC's size.
class Rig {
 public:
  explicit Rig(const std::string& more = "") {
    std::ofstream path(folder_ / "straight.tum");
    for (int k = 0; k <= 1200; ++k) path << 0.01 * k << " " << 0.01 * k << " 0 1.2 0 0 0 1\n";
    path.close();
    const test::Outcome made = test::virSlam(
        "simulate --out " + quoted(rawlog()) +
        " --set simulator.cameras=2 --set simulator.ranges=false --set simulator.seed=3"
        " --set Robot_A.trajectory=" +
        (folder_ / "straight.tum").string() +
        " --set Camera.width_px=376 --set Camera.height_px=240 --set Camera.fx_px=229"
        " --set Camera.fy_px=229 --set Camera.cx_px=184 --set Camera.cy_px=124 " +
        more);
    EXPECT_EQ(made.code, 0) << made.text;
  }
  test::RunResult run(const std::string& more) const {
    return test::runVir(rawlog(), (folder_ / "out").string(), more);
  }
  std::string rawlog() const { return (folder_ / "a.rawlog").string(); }

 private:
  test::TempFolder folder_;
};

const Rig& drive() {
  static const Rig rig;
  return rig;
}

TEST(RigCli, TwoCamerasHoldTheScaleOfADriveAtConstantSpeed) {
  const test::RunResult r = drive().run(kAuto);
  ASSERT_EQ(r.outcome.code, 0) << r.outcome.text;
  EXPECT_EQ(r.summary["frames"], 240);  // the first camera's
  EXPECT_EQ(r.counter("cam1_images"), 240);
  EXPECT_GE(r.counter("cam1_taken"), 236);
  EXPECT_GT(r.trajectory.size(), 170u);
  EXPECT_LE(r.summary["ate_posyaw_m"], 0.12);
}

TEST(RigCli, PairsInOneObservationRunAsTheCamerasTheyAre) {
  const test::TempFolder folder;
  const std::string euroc = (folder / "e").string(), pairs = (folder / "pairs.rawlog").string();
  ASSERT_EQ(
      test::virSlam("export " + quoted(drive().rawlog()) + " --format euroc --out " + quoted(euroc))
          .code,
      0);
  const test::Outcome made =
      test::virSlam("import euroc " + quoted(euroc) + " --stereo --out " + quoted(pairs));
  ASSERT_EQ(made.code, 0) << made.text;
  EXPECT_NE(made.text.find("240 pairs of images in one observation each, 0 images without"),
            std::string::npos)
      << made.text;
  const test::RunResult r = test::runVir(pairs, (folder / "out").string(), kAuto);
  ASSERT_EQ(r.outcome.code, 0) << r.outcome.text;
  EXPECT_EQ(r.summary["frames"], 240);
  EXPECT_EQ(r.counter("cam1_images"), 240);
  EXPECT_LE(r.summary["ate_posyaw_m"], 0.12);
}

TEST(RigCli, LiveTwoCamerasOfTheirOwnThreadsAreOneRig) {
  const test::TempFolder folder;
  std::string ini = "[Estimator]\nother_cameras = auto\n";
  for (const char* label : {"CAM0", "CAM1", "IMU0", "GT"}) {
    ini += "[replay_" + std::string(label) + "]\ndriver = RawlogReplay\nprocess_rate = 200\n" +
           "rawlog = " + drive().rawlog() + "\nlabels = " + label + "\nclock = keep\n";
  }
  test::writeText((folder / "live.ini").string(), ini);
  const std::string out = (folder / "out").string();
  const test::Outcome outcome =
      test::virSlam("record " + quoted((folder / "live.ini").string()) + " --estimate --out " +
                    quoted((folder / "a.rawlog").string()) + " --results " + quoted(out));
  ASSERT_EQ(outcome.code, 0) << outcome.text;
  const auto summary = nlohmann::json::parse(test::readText(out + "/summary.json"));
  EXPECT_GE(summary["counters"]["cam1_matched"], 1000) << outcome.text;
  if (summary["counters"]["images_dropped_late"] != 0) GTEST_SKIP() << "too slow to compare";
  // Threads of their own on a busy machine: some may come too late for their partner.
  EXPECT_GE(summary["counters"]["cam1_images"], 200);
  EXPECT_LE(summary["counters"]["cam1_images"], 240);
  EXPECT_LE(summary["ate_posyaw_m"], 0.12);
}

TEST(RigCli, UnaskedOneCameraIsUsedAndTheOtherNamed) {
  const test::RunResult r = drive().run("");
  EXPECT_EQ(r.outcome.code, 1) << r.outcome.text;  // at constant speed one camera sees no scale
  EXPECT_NE(r.outcome.text.find("other_cameras = CAM1"), std::string::npos) << r.outcome.text;
}

TEST(RigCli, ACameraNamedTwiceIsRefused) {
  for (const char* others : {"CAM0", "\"CAM1 CAM1\""}) {
    const test::RunResult r = drive().run(std::string("--set Estimator.other_cameras=") + others);
    EXPECT_EQ(r.outcome.code, 2) << r.outcome.text;
    EXPECT_NE(r.outcome.text.find("name each camera beside CAM0 once"), std::string::npos)
        << r.outcome.text;
  }
}

TEST(RigCli, ACameraThatStaysBlackIsCounted) {
  const Rig rig("--set Camera1.black_s=\"0 100\"");
  const test::RunResult r = rig.run(kAuto);
  EXPECT_EQ(r.counter("cam1_unusable"), 240);
  EXPECT_EQ(r.summary["frames"], 240);
}

TEST(RigCli, WithoutTheFirstCameraForAWhileTheOtherGoesOn) {
  const Rig rig("--set Camera.missing_s=\"5 8\"");
  const test::RunResult r = rig.run(kAuto);
  ASSERT_EQ(r.outcome.code, 0) << r.outcome.text;
  EXPECT_EQ(r.summary["frames"], 180);
  EXPECT_NEAR(r.counter("cam1_without_partner"), 60, 2);
  EXPECT_EQ(r.summary["resets"], 0);
  EXPECT_LE(r.summary["ate_posyaw_m"], 0.12);
}

/// A calibration file of the drive's first camera and a second one, as `change` leaves that.
std::string chain(const test::RunResult& of, const std::function<void(CameraMount*)>& change) {
  const auto file = formats::readCalibrationFile(of.folder + "/calibration.yaml");
  const formats::CalibratedCamera &a = file.cameras.at(0), &b = file.cameras.at(1);
  Calibration c;
  c.camera = a.camera;
  c.T_B_C = a.T_B_C.value();
  CameraMount second{b.camera, b.T_B_C.value(), 0, 0};
  change(&second);
  c.further = {second};
  const std::string name = of.folder + "_given.yaml";
  test::writeText(name, results::calibrationYaml(c, CalibrationSigma(), {"CAM1"}));
  return " --calibration " + quoted(name);
}

TEST(RigCli, BothCamerasCalibrationIsWrittenAndTakenInAgain) {
  const test::RunResult first = drive().run(kAuto);
  ASSERT_EQ(first.outcome.code, 0) << first.outcome.text;
  const auto& found = first.summary["calibration"]["further"]["CAM1"];
  ASSERT_EQ(found["T_B_C"].size(), 16u);
  EXPECT_NEAR(found["fx"], 229, 3);
  // The rig is known as well against the IMU as its first camera is.
  const auto& all = first.summary["calibration"];
  for (const char* key : {"T_B_C_position_sigma_m", "T_B_C_rotation_sigma_rad", "fx_sigma"}) {
    ASSERT_TRUE(found.contains(key)) << key;
    EXPECT_GT(found[key], 0) << key;
    EXPECT_NEAR(found[key].get<double>() / all[key].get<double>(), 1, 0.5) << key;
  }
  // As given 5 mm off across, it begins there.
  const std::string given = chain(first, [](CameraMount* m) { m->T_B_C.p.z() += 0.005; });
  const double z = found["T_B_C"][11];
  const test::RunResult again = drive().run(kAuto + given);
  ASSERT_EQ(again.outcome.code, 0) << again.outcome.text;
  EXPECT_NEAR(again.summary["calibration"]["further"]["CAM1"]["T_B_C"][11], z + 0.005, 0.003);
}

/// A flight that comes back to where it was.
const Rig& eight() {
  static const Rig rig(
      " --set Robot_A.trajectory= --set Robot_A.flight=eight --set Robot_A.length_m=14");
  return rig;
}

TEST(RigCli, ALengthBetweenTheCamerasThatTheImuContradictsIsNamed) {
  const test::RunResult first = eight().run(kAuto);
  ASSERT_EQ(first.outcome.code, 0) << first.outcome.text;
  EXPECT_EQ(first.summary["verdict"], "good") << first.outcome.text;
  const test::RunResult r = eight().run(kAuto + chain(first, [](CameraMount* m) {
                                          m->T_B_C.p.y() -= 0.016;  // 0.11 m to the right
                                        }));
  EXPECT_NE(r.outcome.text.find("the distance of CAM1 from CAM0 comes out as 0.1"),
            std::string::npos)
      << r.outcome.text;
  EXPECT_EQ(r.summary["verdict"], "doubtful");
}

TEST(RigCli, AMapOfTwoCamerasServesOneAndTheOtherWayRound) {
  const Rig& rig = eight();
  const std::string map = " --map ", save = " --save-map ";
  const test::TempFolder folder;
  const std::string of_two = quoted((folder / "two.virmap").string()),
                    of_one = quoted((folder / "one.virmap").string());
  ASSERT_EQ(rig.run(kAuto + save + of_two).outcome.code, 0);
  ASSERT_EQ(rig.run(save + of_one).outcome.code, 0);
  for (const std::string& more : {map + of_two, kAuto + map + of_one}) {
    const test::RunResult r = rig.run(more);
    ASSERT_EQ(r.outcome.code, 0) << more << r.outcome.text;
    EXPECT_TRUE(r.summary.contains("in_map_s")) << more << r.outcome.text;
    EXPECT_LE(r.summary["ate_posyaw_m"], 0.1) << more;
  }
}

TEST(RigCli, APairThatNeverMatchesIsNamedInTheVerdict) {
  const test::RunResult first = drive().run(kAuto);
  ASSERT_EQ(first.outcome.code, 0) << first.outcome.text;
  const test::RunResult r = drive().run(kAuto + chain(first, [](CameraMount* m) {
                                          m->T_B_C.q = m->T_B_C.q * expQuat(Vec3(0.3, 0, 0));
                                        }));
  EXPECT_NE(r.outcome.text.find("CAM1 should see what CAM0 sees"), std::string::npos)
      << r.outcome.text;
  EXPECT_NE(r.summary["verdict"], "good");
  EXPECT_LT(r.counter("cam1_matched"), r.counter("cam1_looked_for") / 20);
}

}  // namespace
}  // namespace vir
