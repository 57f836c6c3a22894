#include "sensor_yaml.h"

#include <gtest/gtest.h>

#include "input_error.h"
#include "vir_test_euroc_folder.h"

namespace vir::euroc {
namespace {

std::string camYaml(const test::EurocFolder& f) { return (f.mav0() / "cam0/sensor.yaml").string(); }

/// The error of reading cam0/sensor.yaml after replacing `from` by `to`.
std::string errorAfter(const std::string& from, const std::string& to) {
  test::EurocFolderOptions o;
  o.images = 1;
  const test::EurocFolder f(o);
  f.replace("cam0/sensor.yaml", from, to);
  try {
    readCameraYaml(camYaml(f));
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("cam0/sensor.yaml"), std::string::npos) << e.what();
    return e.what();
  }
  return "";
}

TEST(CameraYaml, ReadsIntrinsicsDistortionAndPose) {
  const test::EurocFolder f;
  const CameraYaml c = readCameraYaml(camYaml(f));
  EXPECT_EQ(c.camera.width, 64);
  EXPECT_EQ(c.camera.height, 48);
  EXPECT_DOUBLE_EQ(c.camera.fx, 40.5);
  EXPECT_DOUBLE_EQ(c.camera.fy, 41.5);
  EXPECT_DOUBLE_EQ(c.camera.cx, 31.25);
  EXPECT_DOUBLE_EQ(c.camera.cy, 24.75);
  EXPECT_EQ(c.camera.distortion, Distortion::radtan);
  EXPECT_EQ(c.camera.dist, (std::array<double, 8>{-0.28, 0.07, 0.0002, 1.5e-05, 0}));
  EXPECT_LT((c.T_B_C.p - Vec3(0.1, 0.02, 0.03)).norm(), 1e-12);
  // The optical axis is the body's x axis.
  EXPECT_LT((c.T_B_C.q * Vec3::UnitZ() - Vec3::UnitX()).norm(), 1e-9);
}

TEST(CameraYaml, KnowsTheEquidistantLens) {
  test::EurocFolderOptions o;
  o.tum_vi = true;
  const test::EurocFolder f(o);
  EXPECT_EQ(readCameraYaml(camYaml(f)).camera.distortion, Distortion::equidistant);
}

TEST(CameraYaml, ReadsOpenCvMatricesAndNestedLists) {
  const test::EurocFolder f;
  f.replace("cam0/sensor.yaml", "T_BS:\n", "T_BS: !!opencv-matrix\n");
  EXPECT_NEAR(readCameraYaml(camYaml(f)).T_B_C.p.x(), 0.1, 1e-12);
  f.replace("cam0/sensor.yaml", "T_BS: !!opencv-matrix\n",
            "T_BS: [[1,0,0,0.5],[0,1,0,0],[0,0,1,0],[0,0,0,1]]\nunused:\n");
  EXPECT_NEAR(readCameraYaml(camYaml(f)).T_B_C.p.x(), 0.5, 1e-12);
}

TEST(CameraYaml, NonsenseIsNamed) {
  EXPECT_NE(errorAfter("resolution: [64, 48]", "resolution: [0, 48]").find("resolution"),
            std::string::npos);
  EXPECT_NE(errorAfter("resolution: [64, 48]", "resolution: wide").find("resolution"),
            std::string::npos);
  EXPECT_NE(errorAfter("[40.5,", "[-40.5,").find("focal"), std::string::npos);
  EXPECT_NE(errorAfter("[40.5,", "[.nan,").find("not finite"), std::string::npos);
  EXPECT_NE(errorAfter("[40.5,", "[abc,").find("intrinsics is not a number"), std::string::npos);
  EXPECT_NE(errorAfter("31.25", "3125").find("principal point"), std::string::npos);
  EXPECT_NE(errorAfter("pinhole", "omni").find("omni"), std::string::npos);
  EXPECT_NE(errorAfter("radial-tangential", "rational").find("rational"), std::string::npos);
  EXPECT_NE(errorAfter("-0.28, 0.07,", "-0.28,").find("distortion_coefficients"),
            std::string::npos);
  EXPECT_NE(errorAfter("0.0, 0.0, 1.0, 0.1", "0.0, 0.0, 2.0, 0.1").find("rigid"),
            std::string::npos);
  EXPECT_NE(errorAfter("0.0, 0.0, 1.0, 0.1", "0.0, 0.0, -1.0, 0.1").find("rigid"),
            std::string::npos);
  EXPECT_NE(errorAfter("0.0, 0.0, 1.0, 0.1", "0.0, 1.0, 0.1").find("15 numbers"),
            std::string::npos);
  EXPECT_NE(errorAfter("resolution: [", "resolution: [[[").find("YAML"), std::string::npos);
}

TEST(CameraYaml, AMissingOrEmptyFileIsNamed) {
  const test::EurocFolder f;
  f.write("cam0/sensor.yaml", "");
  EXPECT_THROW(readCameraYaml(camYaml(f)), InputError);
  EXPECT_THROW(readCameraYaml("/nonexistent/sensor.yaml"), InputError);
}

TEST(ImuYaml, ReadsNoise) {
  const test::EurocFolder f;
  ProblemLog log;
  const ImuYaml imu = readImuYaml((f.mav0() / "imu0/sensor.yaml").string(), &log);
  EXPECT_TRUE(imu.has_noise);
  EXPECT_DOUBLE_EQ(imu.gyro_noise_density, 1.7e-4);
  EXPECT_DOUBLE_EQ(imu.gyro_random_walk, 1.9e-5);
  EXPECT_DOUBLE_EQ(imu.acc_noise_density, 2e-3);
  EXPECT_DOUBLE_EQ(imu.acc_random_walk, 3e-3);
  EXPECT_TRUE(log.messages().empty());
}

TEST(ImuYaml, ZeroOrMissingNoiseIsNotPassedOn) {
  const test::EurocFolder f;
  f.replace("imu0/sensor.yaml", "1.7e-04", "0");
  ProblemLog log;
  EXPECT_FALSE(readImuYaml((f.mav0() / "imu0/sensor.yaml").string(), &log).has_noise);
  EXPECT_EQ(log.messages().size(), 1u);
}

TEST(UwbYaml, ReadsAntennaAndSigma) {
  const test::EurocFolder f;
  const UwbYaml uwb = readUwbYaml((f.mav0() / "uwb0/sensor.yaml").string());
  EXPECT_LT((uwb.T_B_U.p - Vec3(0.1, 0.2, 0.3)).norm(), 1e-12);
  EXPECT_DOUBLE_EQ(uwb.sigma_m.value(), 0.07);
  f.replace("uwb0/sensor.yaml", "0.07", "-1");
  EXPECT_THROW(readUwbYaml((f.mav0() / "uwb0/sensor.yaml").string()), InputError);
}

}  // namespace
}  // namespace vir::euroc
