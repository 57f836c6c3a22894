/// Rendered rigs through the whole program. Measured when this was written (drive 12 m, seed 3):
/// one camera finds no scale, two 0.03 m.
#include <gtest/gtest.h>

#include <fstream>

#include "end_to_end.h"
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

 private:
  std::string rawlog() const { return (folder_ / "a.rawlog").string(); }
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

TEST(RigCli, UnaskedOneCameraIsUsedAndTheOtherNamed) {
  const test::RunResult r = drive().run("");
  EXPECT_EQ(r.outcome.code, 1) << r.outcome.text;  // at constant speed one camera sees no scale
  EXPECT_NE(r.outcome.text.find("other_cameras = CAM1"), std::string::npos) << r.outcome.text;
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

}  // namespace
}  // namespace vir
