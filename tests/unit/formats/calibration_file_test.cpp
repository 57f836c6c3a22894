#include "vir/formats/calibration_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "vir_test_paths.h"
#include "vir_test_temp_folder.h"

namespace vir::formats {
namespace {

using Dist = std::array<double, 8>;

CalibrationFile fixture(const std::string& name) {
  return readCalibrationFile(test::sourceDir() + "/tests/fixtures/calibration/" + name);
}

/// What a file of this text says.
CalibrationFile read(const std::string& text) {
  const test::TempFolder folder;
  test::writeText(folder / "c.yaml", text);
  return readCalibrationFile((folder / "c.yaml").string());
}

std::string errorOf(const std::string& text) {
  try {
    read(text);
  } catch (const CalibrationError& e) {
    return e.what();
  }
  return "";
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// The camera of every fixture: EuRoC's cam0.
void expectEurocCamera(const CalibratedCamera& c) {
  EXPECT_EQ(c.label, "cam0");
  EXPECT_EQ(c.camera.width, 752);
  EXPECT_EQ(c.camera.height, 480);
  EXPECT_DOUBLE_EQ(c.camera.fx, 458.654);
  EXPECT_DOUBLE_EQ(c.camera.fy, 457.296);
  EXPECT_DOUBLE_EQ(c.camera.cx, 367.215);
  EXPECT_DOUBLE_EQ(c.camera.cy, 248.375);
}

void expectEurocLens(const CalibratedCamera& c) {
  EXPECT_EQ(c.camera.distortion, Distortion::radtan);
  EXPECT_EQ(c.camera.dist, (Dist{-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05}));
}

/// The right way round: the camera sits at (-22, -65, 10) mm and looks along the IMU's z.
void expectEurocPose(const CalibratedCamera& c, double tolerance) {
  ASSERT_TRUE(c.T_B_C.has_value());
  EXPECT_LT((c.T_B_C->p - Vec3(-0.0216401454975, -0.064676986768, 0.00981073058949)).norm(),
            tolerance);
  EXPECT_LT(
      (c.T_B_C->q * Vec3::UnitX() - Vec3(0.0148655429818, 0.999557249008, -0.0257744366974)).norm(),
      tolerance);
  EXPECT_NEAR(c.T_B_C->q.norm(), 1, 1e-15);
}

TEST(CalibrationFile, ReadsKalibr) {
  const CalibrationFile f = fixture("kalibr.yaml");
  ASSERT_EQ(f.cameras.size(), 1u);
  expectEurocCamera(f.cameras[0]);
  expectEurocLens(f.cameras[0]);
  expectEurocPose(f.cameras[0], 2e-6);  // written with 7 decimals
  // t_imu = t_cam + shift, our own sign.
  EXPECT_DOUBLE_EQ(f.cameras[0].time_offset_s.value(), -0.0123);
  EXPECT_EQ(f.cameras[0].topic, "/cam0/image_raw");
  EXPECT_TRUE(f.notes.empty());
}

/// YAML forbids tabs as indentation, editors put them there.
TEST(CalibrationFile, TabsAreBlanksWhereTheMeaningIsClear) {
  const std::string camera =
      "cam0:\n>camera_model: pinhole\n>intrinsics: [458.654,\t457.296, 367.215, 248.375]\n"
      ">distortion_model: radtan\n>distortion_coeffs: [-0.28, 0.07, 0.0002, 0.00002]\n"
      ">resolution: [752, 480]\n>T_cam_imu:\n>- [1, 0, 0, 0]\n>- [0, 1, 0, 0]\n>- [0, 0, 1, 0.1]\n"
      ">- [0, 0, 0, 1]\n";
  const auto with = [&](const std::string& indent, const std::string& of_pose) {
    std::string out;
    bool pose = false;
    for (const char c : camera) {
      if (c == '>') {
        out += pose ? of_pose : indent;
      } else {
        out += c;
        pose = pose || c == 'T';
      }
    }
    return out;
  };
  const CalibrationFile blanks = read(with("  ", "  "));
  for (const std::string& text : {with("\t", "\t"), with("\t\t", "\t\t")}) {
    const CalibrationFile tabs = read(text);
    ASSERT_EQ(tabs.cameras.size(), 1u);
    expectEurocCamera(tabs.cameras[0]);
    ASSERT_TRUE(tabs.cameras[0].T_B_C.has_value());
    EXPECT_EQ(tabs.cameras[0].T_B_C->p, blanks.cameras[0].T_B_C->p);
    EXPECT_EQ(tabs.cameras[0].T_B_C->p, Vec3(0, 0, -0.1));
  }
  const std::string mixed = errorOf(with("    ", "\t"));
  EXPECT_TRUE(contains(mixed, "line 8 is indented with a tab")) << mixed;
  EXPECT_TRUE(contains(mixed, "write blanks")) << mixed;
  EXPECT_FALSE(contains(errorOf("cam0: [1, 2\n"), "tab"));
}

TEST(CalibrationFile, ReadsOpenCvsDialect) {
  const CalibrationFile f = fixture("opencv.yaml");
  ASSERT_EQ(f.cameras.size(), 1u);
  expectEurocCamera(f.cameras[0]);
  expectEurocLens(f.cameras[0]);
  expectEurocPose(f.cameras[0], 1e-9);
  EXPECT_FALSE(f.cameras[0].time_offset_s.has_value());
}

TEST(CalibrationFile, ReadsOrbSlam) {
  const CalibrationFile f = fixture("orbslam3.yaml");
  ASSERT_EQ(f.cameras.size(), 1u);
  expectEurocCamera(f.cameras[0]);
  expectEurocLens(f.cameras[0]);
  expectEurocPose(f.cameras[0], 1e-9);
  EXPECT_FALSE(f.imu_noise.has_value());
}

TEST(CalibrationFile, ReadsVins) {
  const CalibrationFile f = fixture("vins.yaml");
  ASSERT_EQ(f.cameras.size(), 1u);
  expectEurocCamera(f.cameras[0]);
  expectEurocLens(f.cameras[0]);
  EXPECT_FALSE(f.cameras[0].T_B_C.has_value());
  ASSERT_EQ(f.notes.size(), 1u);
  EXPECT_TRUE(contains(f.notes[0], "body_T_cam0")) << f.notes[0];
}

TEST(CalibrationFile, ReadsRational) {
  const CalibrationFile f = fixture("rational.yaml");
  ASSERT_EQ(f.cameras.size(), 1u);
  expectEurocCamera(f.cameras[0]);
  expectEurocPose(f.cameras[0], 1e-9);
  EXPECT_EQ(f.cameras[0].camera.distortion, Distortion::rational);
  EXPECT_EQ(f.cameras[0].camera.dist,
            (Dist{10.2, -120.5, 0.0003, -0.0005, 430.1, 10.0, -119.1, 426.0}));
}

TEST(CalibrationFile, ReadsTwoCamerasAndTheImuOfAChain) {
  const CalibrationFile f = read(
      "cam0:\n  camera_model: ds\n  intrinsics: [-0.2, 0.59, 350.0, 351.0, 370.0, 240.0]\n"
      "  distortion_model: none\n  distortion_coeffs: []\n  resolution: [752, 480]\n"
      "  T_imu_cam:\n  - [0, 0, 1, 0.1]\n  - [-1, 0, 0, 0.2]\n  - [0, -1, 0, 0.3]\n"
      "  - [0, 0, 0, 1]\n  timeshift_cam_imu_sigma: 0.001\n  T_cam_imu_sigma: [1, 2]\n"
      "cam1:\n  camera_model: omni\n  intrinsics: [1.6, 900.0, 901.0, 371.0, 241.0]\n"
      "  distortion_model: radtan\n  distortion_coeffs: [-0.1, 0.02, 0.001, -0.002]\n"
      "  resolution: [752, 480]\n"
      "  T_cn_cnm1: [[1,0,0,-0.11],[0,1,0,0],[0,0,1,0],[0,0,0,1]]\n"
      "imu0:\n  gyroscope_noise_density: 0.001\n  gyroscope_random_walk: 0.0001\n"
      "  accelerometer_noise_density: 0.01\n  accelerometer_random_walk: 0.002\n"
      "  update_rate: 200.0\n  rostopic: /imu\n  T_i_b: [[1]]\n");
  ASSERT_EQ(f.cameras.size(), 2u);
  EXPECT_EQ(f.cameras[0].camera.distortion, Distortion::double_sphere);
  EXPECT_EQ(f.cameras[0].camera.dist, (Dist{-0.2, 0.59}));
  EXPECT_DOUBLE_EQ(f.cameras[0].camera.fx, 350);
  EXPECT_DOUBLE_EQ(f.cameras[0].camera.cy, 240);
  EXPECT_LT((f.cameras[0].T_B_C->p - Vec3(0.1, 0.2, 0.3)).norm(), 1e-12);
  const CalibratedCamera* right = f.camera("cam1");
  ASSERT_NE(right, nullptr);
  EXPECT_EQ(right->camera.distortion, Distortion::omni);
  EXPECT_EQ(right->camera.dist, (Dist{1.6, -0.1, 0.02, 0.001, -0.002}));
  EXPECT_DOUBLE_EQ(right->camera.fy, 901);
  // 11 cm to the right of the first camera, whose x is the body's -y.
  EXPECT_LT((right->T_B_C->p - Vec3(0.1, 0.09, 0.3)).norm(), 1e-12);
  EXPECT_DOUBLE_EQ(f.imu_noise.value().gyro_noise_density, 0.001);
  EXPECT_DOUBLE_EQ(f.imu_noise->gyro_random_walk, 0.0001);
  EXPECT_DOUBLE_EQ(f.imu_noise->acc_noise_density, 0.01);
  EXPECT_DOUBLE_EQ(f.imu_noise->acc_random_walk, 0.002);
  EXPECT_DOUBLE_EQ(f.imu_rate_hz.value(), 200);
  EXPECT_EQ(f.imu_topic, "/imu");
  EXPECT_TRUE(f.notes.empty()) << f.notes[0];
}

TEST(CalibrationFile, AChainWithoutTheImuSaysWhatIsMissing) {
  const CalibrationFile f = read(
      "cam0: {camera_model: pinhole, intrinsics: [400, 400, 320, 240], distortion_model: "
      "equidistant, distortion_coeffs: [0.1, 0.2, 0.3, 0.4], resolution: [640, 480]}\n");
  EXPECT_EQ(f.cameras.at(0).camera.distortion, Distortion::equidistant);
  ASSERT_EQ(f.notes.size(), 1u);
  EXPECT_TRUE(contains(f.notes[0], "cam0") && contains(f.notes[0], "T_cam_imu")) << f.notes[0];
}

TEST(CalibrationFile, ReadsTheNoiseOfAnImu) {
  const CalibrationFile f = read(
      "accelerometer_noise_density: 0.01\naccelerometer_random_walk: 0.0002\n"
      "gyroscope_noise_density: 0.005\ngyroscope_random_walk: 4.0e-06\nrostopic: /imu0\n"
      "update_rate: 250.0\n");
  EXPECT_TRUE(f.cameras.empty());
  EXPECT_DOUBLE_EQ(f.imu_noise.value().gyro_random_walk, 4e-6);
  EXPECT_DOUBLE_EQ(f.imu_rate_hz.value(), 250);
  const CalibrationFile half = read("gyroscope_noise_density: 0.005\n");
  EXPECT_FALSE(half.imu_noise.has_value());
  EXPECT_EQ(half.notes.size(), 1u);
}

constexpr const char* kCameraInfo =
    "image_width: 640\nimage_height: 480\ncamera_name: head\n"
    "camera_matrix:\n  rows: 3\n  cols: 3\n  data: [500, 0, 320, 0, 501, 240, 0, 0, 1]\n"
    "distortion_model: plumb_bob\n"
    "distortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [0.1, -0.2, 0.001, 0.002, 0.03]\n"
    "rectification_matrix:\n  rows: 3\n  cols: 3\n  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n";

TEST(CalibrationFile, ReadsCameraInfo) {
  const CalibrationFile f = read(kCameraInfo);
  const CameraCalibration& c = f.cameras.at(0).camera;
  EXPECT_DOUBLE_EQ(c.fx, 500);
  EXPECT_DOUBLE_EQ(c.fy, 501);
  EXPECT_DOUBLE_EQ(c.cx, 320);
  EXPECT_DOUBLE_EQ(c.cy, 240);
  EXPECT_EQ(c.distortion, Distortion::radtan);
  EXPECT_EQ(c.dist, (Dist{0.1, -0.2, 0.001, 0.002, 0.03}));
  EXPECT_EQ(f.notes.size(), 1u);  // the pose
}

TEST(CalibrationFile, ReadsOpenCvsSamples) {
  const CalibrationFile f = read(
      "%YAML:1.0\n---\ncalibration_time: \"today\"\nimage_width: 640\nimage_height: 480\n"
      "camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n"
      "   data: [ 500., 0., 320., 0., 501., 240., 0., 0., 1. ]\n"
      "distortion_coefficients: !!opencv-matrix\n   rows: 14\n   cols: 1\n   dt: d\n"
      "   data: [ 1., 2., 3., 4., 5., 6., 7., 8., 0., 0., 0., 0., 0., 0. ]\n");
  EXPECT_EQ(f.cameras.at(0).camera.distortion, Distortion::rational);
  EXPECT_EQ(f.cameras[0].camera.dist, (Dist{1, 2, 3, 4, 5, 6, 7, 8}));
  EXPECT_TRUE(contains(f.notes.at(0), "rational_polynomial"));
}

TEST(CalibrationFile, ReadsVinsMainFileWithTheCamerasItNames) {
  const test::TempFolder folder;
  test::writeText(folder / "cam0.yaml",
                  "%YAML:1.0\n---\nmodel_type: MEI\nimage_width: 640\nimage_height: 480\n"
                  "mirror_parameters:\n   xi: 1.9\ndistortion_parameters:\n   k1: 0.1\n"
                  "   k2: 0.2\n   p1: 0.3\n   p2: 0.4\nprojection_parameters:\n   gamma1: 700\n"
                  "   gamma2: 701\n   u0: 320\n   v0: 240\n");
  test::writeText(folder / "cam1.yaml",
                  "%YAML:1.0\n---\nmodel_type: KANNALA_BRANDT\nimage_width: 640\n"
                  "image_height: 480\nprojection_parameters:\n   k2: 0.1\n   k3: 0.2\n   k4: 0.3\n"
                  "   k5: 0.4\n   mu: 300\n   mv: 301\n   u0: 320\n   v0: 240\n");
  const std::string matrix = " !!opencv-matrix\n   rows: 4\n   cols: 4\n   dt: d\n   data: ";
  test::writeText(folder / "vins.yaml",
                  "%YAML:1.0\n\nimu_topic: \"/imu0\"\nimage0_topic: \"/left\"\n"
                  "image1_topic: \"/right\"\ncam0_calib: \"cam0.yaml\"\ncam1_calib: \"cam1.yaml\"\n"
                  "body_T_cam0:" +
                      matrix +
                      "[0,0,1,0.1, -1,0,0,0.2, 0,-1,0,0.3, 0,0,0,1]\n"
                      "body_T_cam1:" +
                      matrix +
                      "[1,0,0,0, 0,1,0,0, 0,0,1,0.5, 0,0,0,1]\n"
                      "acc_n: 0.1\ngyr_n: 0.01\ntd: 0.004\n");
  const CalibrationFile f = readCalibrationFile((folder / "vins.yaml").string());
  ASSERT_EQ(f.cameras.size(), 2u);
  EXPECT_EQ(f.cameras[0].camera.distortion, Distortion::omni);
  EXPECT_EQ(f.cameras[0].camera.dist, (Dist{1.9, 0.1, 0.2, 0.3, 0.4}));
  EXPECT_DOUBLE_EQ(f.cameras[0].camera.fx, 700);
  EXPECT_EQ(f.cameras[1].camera.distortion, Distortion::equidistant);
  EXPECT_EQ(f.cameras[1].camera.dist, (Dist{0.1, 0.2, 0.3, 0.4}));
  EXPECT_LT((f.cameras[0].T_B_C->p - Vec3(0.1, 0.2, 0.3)).norm(), 1e-12);
  EXPECT_NEAR(f.cameras[1].T_B_C->p.z(), 0.5, 1e-12);
  EXPECT_DOUBLE_EQ(f.cameras[0].time_offset_s.value(), 0.004);
  EXPECT_EQ(f.cameras[1].topic, "/right");
  EXPECT_FALSE(f.imu_noise.has_value());
  EXPECT_TRUE(contains(f.notes.at(0), "acc_n"));
}

TEST(CalibrationFile, ReadsOpenVinsMainFileWithTheFilesItNames) {
  const test::TempFolder folder;
  test::writeText(folder / "chain.yaml",
                  "%YAML:1.0\n\ncam0:\n  T_imu_cam: #rotation from camera to IMU\n"
                  "    - [0, 0, 1, 0.1]\n    - [-1, 0, 0, 0.2]\n    - [0, -1, 0, 0.3]\n"
                  "    - [0.0, 0.0, 0.0, 1.0]\n  cam_overlaps: [1]\n  camera_model: pinhole\n"
                  "  distortion_coeffs: [0.1, 0.2, 0.3, 0.4]\n  distortion_model: radtan\n"
                  "  intrinsics: [458, 457, 367, 248]\n  resolution: [752, 480]\n");
  test::writeText(folder / "imu.yaml",
                  "%YAML:1.0\n\nimu0:\n  accelerometer_noise_density: 2.0e-03\n"
                  "  accelerometer_random_walk: 3.0e-03\n  gyroscope_noise_density: 1.6e-04\n"
                  "  gyroscope_random_walk: 1.9e-05\n  model: calibrated\n  update_rate: 200.0\n");
  test::writeText(folder / "estimator_config.yaml",
                  "%YAML:1.0\n\nuse_stereo: true\nrelative_config_imu: \"imu.yaml\"\n"
                  "relative_config_imucam: \"chain.yaml\"\n");
  const CalibrationFile f = readCalibrationFile((folder / "estimator_config.yaml").string());
  ASSERT_EQ(f.cameras.size(), 1u);
  EXPECT_LT((f.cameras[0].T_B_C->p - Vec3(0.1, 0.2, 0.3)).norm(), 1e-12);
  EXPECT_DOUBLE_EQ(f.imu_noise.value().acc_random_walk, 3e-3);
}

TEST(CalibrationFile, ReadsOrbSlamsFisheyeAndNoise) {
  const CalibrationFile f = read(
      "%YAML:1.0\nCamera.type: \"KannalaBrandt8\"\nCamera1.fx: 190.9\nCamera1.fy: 190.8\n"
      "Camera1.cx: 254.9\nCamera1.cy: 256.8\nCamera1.k1: 0.0034\nCamera1.k2: 0.0007\n"
      "Camera1.k3: -0.002\nCamera1.k4: 0.0002\nCamera2.fx: 190.4\nCamera2.fy: 190.4\n"
      "Camera2.cx: 252.5\nCamera2.cy: 254.9\nCamera2.k1: 0.0034\nCamera2.k2: 0.0017\n"
      "Camera2.k3: -0.0026\nCamera2.k4: 0.0004\nCamera.width: 512\nCamera.height: 512\n"
      "Tbc: !!opencv-matrix\n   rows: 4\n   cols: 4\n   dt: f\n"
      "   data: [1,0,0,0.1, 0,1,0,0, 0,0,1,0, 0,0,0,1]\n"
      "Stereo.T_c1_c2: !!opencv-matrix\n   rows: 4\n   cols: 4\n   dt: f\n"
      "   data: [1,0,0,0.1, 0,1,0,0, 0,0,1,0, 0,0,0,1]\n"
      "IMU.NoiseGyro: 1e-2\nIMU.NoiseAcc: 1e-1\nIMU.GyroWalk: 1e-6\nIMU.AccWalk: 1e-4\n"
      "IMU.Frequency: 200.0\n");
  ASSERT_EQ(f.cameras.size(), 2u);
  EXPECT_EQ(f.cameras[0].camera.dist, (Dist{0.0034, 0.0007, -0.002, 0.0002}));
  EXPECT_NEAR(f.cameras[1].T_B_C->p.x(), 0.2, 1e-12);
  EXPECT_DOUBLE_EQ(f.imu_noise.value().acc_noise_density, 0.1);
  EXPECT_DOUBLE_EQ(f.imu_rate_hz.value(), 200);
}

/// Without the size of the images, which are there to tell.
TEST(CalibrationFile, ASizeThatIsMissingIsLeftToTheImages) {
  const char* const texts[] = {
      "%YAML:1.0\nCamera.fx: 458\nCamera.fy: 457\nCamera.cx: 367\nCamera.cy: 248\n",
      "model_type: PINHOLE\nprojection_parameters: {fx: 458, fy: 457, cx: 367, cy: 248}\n"
      "distortion_parameters: {k1: 0, k2: 0, p1: 0, p2: 0}\n",
      "cam0: {camera_model: pinhole, intrinsics: [458, 457, 367, 248], distortion_model: none}\n",
      "cam0: {T_imu_cam: [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]], distortion_model: none, "
      "intrinsics: [458, 457, 367, 248]}\n",
      "camera_matrix: {rows: 3, cols: 3, data: [458, 0, 367, 0, 457, 248, 0, 0, 1]}\n"
      "distortion_model: none\n",
      "intrinsics: [458, 457, 367, 248]\ndistortion_model: none\n"};
  for (const char* text : texts) {
    const CalibrationFile f = read(text);
    ASSERT_EQ(f.cameras.size(), 1u) << text;
    CameraCalibration c = f.cameras[0].camera;
    EXPECT_EQ(c.width, 0) << text;
    EXPECT_TRUE(std::any_of(f.notes.begin(), f.notes.end(), [](const std::string& n) {
      return contains(n, "size of the images of cam0");
    })) << text;
    EXPECT_THROW(takeSizeOfImages(376, 240, &c), CalibrationError);
    EXPECT_THROW(takeSizeOfImages(0, 0, &c), CalibrationError);
    takeSizeOfImages(752, 480, &c);
    EXPECT_EQ(c.width, 752);
    EXPECT_EQ(c.height, 480);
    EXPECT_EQ(c.cx, 367);
  }
  // Half a size is a fault.
  EXPECT_TRUE(contains(errorOf("%YAML:1.0\nCamera.fx: 458\nCamera.fy: 457\nCamera.cx: 367\n"
                               "Camera.cy: 248\nCamera.width: 752\n"),
                       "Camera.height"));
}

TEST(CalibrationFile, SaysWhatIsWrong) {
  EXPECT_TRUE(contains(errorOf("a: 1\nb: 2\n"), "a, b"));
  EXPECT_TRUE(contains(errorOf("cam0: {camera_model: eucm, intrinsics: [1], resolution: [64, 48], "
                               "distortion_model: none}\n"),
                       "eucm"));
  EXPECT_TRUE(contains(errorOf("cam0: {camera_model: ds, intrinsics: [1, 2, 3, 4], resolution: "
                               "[64, 48], distortion_model: none}\n"),
                       "`cam0.intrinsics` of ds must be [xi, alpha, fx, fy, cx, cy]"));
  EXPECT_TRUE(contains(errorOf("Camera.type: \"Stereographic\"\nCamera.fx: 1\n"), "Stereographic"));
  EXPECT_TRUE(contains(errorOf("model_type: SCARAMUZZA\nimage_width: 64\nimage_height: 48\n"
                               "projection_parameters: {fx: 1}\n"),
                       "SCARAMUZZA"));
  EXPECT_THROW(readCalibrationFile("/nonexistent/c.yaml"), CalibrationError);
  EXPECT_THROW(readCalibrationFile("/"), CalibrationError);
}

TEST(CalibrationFile, TimeShiftsInMillisecondsAreNamed) {
  const std::string head = "resolution: [752, 480]\nintrinsics: [458, 457, 367, 248]\n";
  const std::string sensor = head + "distortion_model: none\ntimeshift_cam_imu: ";
  EXPECT_EQ(errorOf(sensor + "12.5\n").substr(errorOf(sensor + "12.5\n").find("c.yaml")),
            "c.yaml: `timeshift_cam_imu` is 12.5, which is read as seconds (milliseconds? then "
            "0.0125); allowed: a number of seconds from -10 to 10");
  const CalibrationFile five = read(sensor + "-5.2\n");
  EXPECT_EQ(five.cameras.at(0).time_offset_s, -5.2);
  EXPECT_TRUE(std::any_of(five.notes.begin(), five.notes.end(), [](const std::string& note) {
    return contains(note, "`timeshift_cam_imu` is -5.2") && contains(note, "milliseconds");
  }));
  const CalibrationFile usual = read(sensor + "-0.03\n");
  EXPECT_EQ(usual.cameras.at(0).time_offset_s, -0.03);
  EXPECT_TRUE(std::none_of(usual.notes.begin(), usual.notes.end(),
                           [](const std::string& note) { return contains(note, "timeshift"); }));
}

TEST(CalibrationFile, DecimalCommasAreNamedWithTheirLine) {
  const std::string head = "%YAML:1.0\nresolution: [752, 480]\ndistortion_model: none\n";
  const std::string list = errorOf(head + "intrinsics: [458,6, 457,2, 367,2, 248,3]\n");
  EXPECT_TRUE(contains(list, "8 numbers, decimal commas? write points (line 4)")) << list;
  const std::string one =
      errorOf(head + "intrinsics: [458.6, 457.2, 367.2, 248.3]\ntimeshift_cam_imu: 0,01\n");
  EXPECT_TRUE(contains(one, "timeshift_cam_imu is not a number (line 5: `0,01`, a decimal comma"))
      << one;
}

}  // namespace
}  // namespace vir::formats
