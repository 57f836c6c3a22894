/// What a calibration must not say is refused with the key that says it.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "vir/formats/calibration_file.h"
#include "vir_test_temp_folder.h"

namespace vir::formats {
namespace {

std::string refusalOf(const std::string& text, std::uintmax_t bytes = 0) {
  const test::TempFolder folder;
  const std::filesystem::path path = folder / "c.yaml";
  test::writeText(path, text);
  if (bytes > 0) std::filesystem::resize_file(path, bytes);
  try {
    readCalibrationFile(path.string());
  } catch (const CalibrationError& e) {
    return e.what();
  }
  return "not refused";
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != text.npos;
}

/// Kalibr's, of a camera with these lines.
std::string kalibr(const std::string& model, const std::string& intrinsics, const std::string& lens,
                   const std::string& more = "") {
  return "cam0:\n  camera_model: " + model + "\n  intrinsics: " + intrinsics +
         "\n  distortion_model: " + lens + "\n  distortion_coeffs: [0, 0, 0, 0]\n" + more;
}

TEST(RefusedCalibration, LensesOutsideTheirModel) {
  const std::string size = "  resolution: [752, 480]\n";
  EXPECT_EQ(refusalOf(kalibr("ds", "[-0.2, 0.6, 400, 400, 376, 240]", "none", size)),
            "not refused");
  for (const char* alpha : {"-0.1", "1.1", ".nan"}) {
    const std::string numbers = std::string("[-0.2, ") + alpha + ", 400, 400, 376, 240]";
    const std::string why = refusalOf(kalibr("ds", numbers, "none", size));
    EXPECT_TRUE(contains(why, "intrinsics")) << alpha << ": " << why;
  }
  EXPECT_EQ(refusalOf(kalibr("omni", "[0, 400, 400, 376, 240]", "radtan", size)), "not refused");
  const std::string xi = refusalOf(kalibr("omni", "[-0.1, 400, 400, 376, 240]", "radtan", size));
  EXPECT_TRUE(contains(xi, "xi of omni must not be negative")) << xi;
  const std::string both =
      refusalOf(kalibr("ds", "[-0.2, 0.6, 400, 400, 376, 240]", "radtan", size));
  EXPECT_TRUE(contains(both, "distortion_model `radtan` does not go with ds")) << both;
}

TEST(RefusedCalibration, SizesAndPosesOfOtherShapes) {
  const auto refusal = [](const std::string& more) {
    return refusalOf(kalibr("pinhole", "[400, 400, 376, 240]", "radtan", more));
  };
  const std::string size = "  resolution: [752, 480]\n";
  const std::string rotation = "1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0";
  EXPECT_EQ(refusal(size + "  T_cam_imu: [" + rotation + ", 0, 0, 0, 1]\n"), "not refused");
  const std::string one = refusal("  resolution: [752]\n");
  EXPECT_TRUE(contains(one, "must be [width, height]")) << one;
  const std::string short_one = refusal(size + "  T_cam_imu: [" + rotation + ", 0, 0, 0]\n");
  EXPECT_TRUE(contains(short_one, "T_cam_imu` has 15 numbers, not 16")) << short_one;
  // A mirror image is no rotation, nor is anything with another scale.
  for (const char* bent : {"1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1",
                           "2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1",
                           "1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 1, 1"}) {
    const std::string why = refusal(size + "  T_cam_imu: [" + bent + "]\n");
    EXPECT_TRUE(contains(why, "T_cam_imu` is not a rigid transform")) << why;
  }
}

TEST(RefusedCalibration, ExtrinsicsOfVins) {
  const auto vins = [](const std::string& rotation, const std::string& translation) {
    return "%YAML:1.0\nmodel_type: PINHOLE\nimage_width: 752\nimage_height: 480\n"
           "distortion_parameters: {k1: 0, k2: 0, p1: 0, p2: 0}\n"
           "projection_parameters: {fx: 400, fy: 400, cx: 376, cy: 240}\n"
           "extrinsicRotation: [" +
           rotation + "]\nextrinsicTranslation: [" + translation + "]\n";
  };
  const std::string turned = "0, -1, 0, 1, 0, 0, 0, 0, 1";
  EXPECT_EQ(refusalOf(vins(turned, "1, 2, 3")), "not refused");
  const std::string two = refusalOf(vins(turned, "1, 2"));
  EXPECT_TRUE(contains(two, "`extrinsicTranslation` must be three numbers")) << two;
  const std::string eight = refusalOf(vins("0, -1, 0, 1, 0, 0, 0, 0", "1, 2, 3"));
  EXPECT_TRUE(contains(eight, "`extrinsicRotation` has 8 numbers, not 9")) << eight;
  const std::string mirror = refusalOf(vins("0, 1, 0, 1, 0, 0, 0, 0, 1", "1, 2, 3"));
  EXPECT_TRUE(contains(mirror, "`extrinsicRotation` is not a rotation")) << mirror;
}

TEST(RefusedCalibration, TooLargeForOne) {
  const std::string why = refusalOf(kalibr("pinhole", "[400, 400, 376, 240]", "radtan"), 5'000'000);
  EXPECT_TRUE(contains(why, "is too large for a calibration")) << why;
}

}  // namespace
}  // namespace vir::formats
