/// No text may bring the readers down: they read it, or say CalibrationError.
#include <gtest/gtest.h>

#include <random>

#include "vir/formats/calibration_file.h"
#include "vir_test_paths.h"
#include "vir_test_temp_folder.h"

namespace vir::formats {
namespace {

void readOrRefuse(const std::filesystem::path& file, const std::string& text) {
  test::writeText(file, text);
  try {
    readCalibrationFile(file.string());
  } catch (const CalibrationError&) {
  }
}

TEST(DamagedCalibration, CutAtEveryByte) {
  const test::TempFolder folder;
  for (const char* name : {"kalibr", "opencv", "vins", "vins_main", "openvins", "orbslam3", "run",
                           "camera_info", "rational"}) {
    const std::string text =
        test::readText(test::sourceDir() + "/tests/fixtures/calibration/" + name + ".yaml");
    ASSERT_FALSE(text.empty());
    for (std::size_t n = 0; n < text.size(); ++n)
      readOrRefuse(folder / "c.yaml", text.substr(0, n));
  }
}

TEST(DamagedCalibration, MutatedBytes) {
  const test::TempFolder folder;
  std::mt19937 random(7);
  for (const char* name : {"kalibr", "opencv", "orbslam3", "vins"}) {
    const std::string text =
        test::readText(test::sourceDir() + "/tests/fixtures/calibration/" + name + ".yaml");
    for (int i = 0; i < 100; ++i) {
      std::string other = text;
      for (int k = 0; k < 3; ++k) other[random() % other.size()] = static_cast<char>(random());
      readOrRefuse(folder / "c.yaml", other);
    }
  }
}

TEST(DamagedCalibration, DepthAndReferencesDoNotGrowWithoutBound) {
  const test::TempFolder folder;
  readOrRefuse(folder / "c.yaml", "intrinsics: " + std::string(100000, '['));
  readOrRefuse(folder / "c.yaml", std::string(100000, '-') + " a");
  std::string nested;
  for (int i = 0; i < 3000; ++i) nested += "- ";
  readOrRefuse(folder / "c.yaml", "intrinsics:\n  " + nested + "1\n");
  std::string bomb = "a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]\n";
  for (int i = 1; i < 12; ++i) {
    const std::string before = "*a" + std::to_string(i - 1);
    bomb += "a" + std::to_string(i) + ": &a" + std::to_string(i) + " [";
    for (int k = 0; k < 10; ++k) bomb += (k > 0 ? ", " : "") + before;
    bomb += "]\n";
  }
  readOrRefuse(folder / "c.yaml", bomb + "resolution: [64, 48]\nintrinsics: *a11\n");
}

}  // namespace
}  // namespace vir::formats
