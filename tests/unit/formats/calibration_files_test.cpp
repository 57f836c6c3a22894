/// Several files of calibration that are used as one: Kalibr writes two.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "vir/formats/calibration_file.h"
#include "vir_test_paths.h"
#include "vir_test_temp_folder.h"

namespace vir::formats {
namespace {

TEST(CalibrationFiles, SeveralAreOne) {
  const test::TempFolder folder;
  const std::string camera = (folder / "cam:chain.yaml").string();  // a colon of its own
  const std::string imu = (folder / "imu.yaml").string();
  std::filesystem::copy(test::sourceDir() + "/tests/fixtures/calibration/camera_info.yaml", camera);
  test::writeText(imu,
                  "rostopic: /imu0\nupdate_rate: 200.0\naccelerometer_noise_density: 0.01\n"
                  "accelerometer_random_walk: 0.0002\ngyroscope_noise_density: 0.005\n"
                  "gyroscope_random_walk: 4.0e-06\n");
  for (const std::string& both : {camera + ":" + imu, imu + ":" + camera}) {
    const CalibrationFile f = readCalibrationFile(both);
    ASSERT_EQ(f.cameras.size(), 1u) << both;
    EXPECT_GT(f.cameras[0].camera.fx, 400);
    ASSERT_TRUE(f.imu_noise.has_value()) << both;
    EXPECT_DOUBLE_EQ(f.imu_noise->gyro_noise_density, 0.005);
    EXPECT_EQ(f.path, both);
  }
  EXPECT_EQ(calibrationPaths(camera), std::vector<std::string>{camera});
  EXPECT_EQ(calibrationPaths("cam:chain.yaml:imu.yaml", folder.path().string()),
            (std::vector<std::string>{camera, imu}));
  EXPECT_EQ(calibrationPaths(""), std::vector<std::string>{});
  EXPECT_EQ(calibrationPaths("/nonexistent/c.yaml"),
            std::vector<std::string>{"/nonexistent/c.yaml"});
}

TEST(CalibrationFiles, TwoOfOnePartAreRefused) {
  const test::TempFolder folder;
  const std::string fixtures = test::sourceDir() + "/tests/fixtures/calibration/";
  const std::string a = fixtures + "camera_info.yaml", b = fixtures + "opencv.yaml";
  try {
    readCalibrationFile(a + ":" + b);
    FAIL();
  } catch (const CalibrationError& e) {
    EXPECT_EQ(std::string(e.what()), a + " and " + b +
                                         " both hold cameras: give one of the two, or one file "
                                         "with all of it");
  }
}

}  // namespace
}  // namespace vir::formats
