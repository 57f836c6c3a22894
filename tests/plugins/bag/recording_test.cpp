/// A bag as readings in time order: roles, stamps, what is wrong with messages.
#include <gtest/gtest.h>

#include "input_error.h"
#include "recording_fixture.h"
#include "vir_test_paths.h"

namespace vir::bag {
namespace {

std::string fixture(const std::string& name) {
  return test::sourceDir() + "/tests/fixtures/bags/" + name;
}

TEST_F(Recording, AllKindsOfBagsGiveTheSame) {
  for (const char* name : {"ros1_lz4.bag", "ros1_unindexed.bag", "ros2_zstd.mcap", "ros2_split",
                           "ros2_message_zstd", "ros2_file_zstd"}) {
    BagOptions o;
    o.source = fixture(name);
    o.topics =
        "camera=/cam0/image_raw imu=/imu0 truth=/vicon/body range=/uwb "
        "range=/my_ranges:ranges[].anchor,ranges[].mm,unit=mm";
    ProblemLog problems;
    BagRecording r(o, &problems);
    std::vector<Reading> all;
    for (Reading x; r.next(&x);) all.push_back(std::move(x));
    EXPECT_TRUE(problems.counters().empty()) << name << ": " << problems.counters()[0].first;
    ASSERT_EQ(r.cameras().size(), 1u);
    const CameraSetup& c = r.cameras()[0];
    EXPECT_EQ(c.intrinsics.fx, 30.5);
    EXPECT_EQ(c.intrinsics.cy, 12.75);
    EXPECT_EQ(c.intrinsics.distortion, Distortion::radtan);
    EXPECT_EQ(c.intrinsics.dist[4], 0.003);
    EXPECT_NEAR((c.T_B_C.p - Vec3(0.1, 0.2, 0.2)).norm(), 0, 1e-15);
    EXPECT_NEAR(c.T_B_C.q.angularDistance(Quat(-0.5, 0.5, -0.5, 0.5)), 0, 1e-12);

    TimeNs first = 0;
    const auto imu = only<ImuSample>(all, &first);
    ASSERT_EQ(imu.size(), 80u) << name;
    EXPECT_EQ(first, kStart);
    EXPECT_EQ(imu[7].t, kStart + 35 * kMs);
    EXPECT_EQ(imu[7].gyro, Vec3(0.01 * 7, -0.02 * 7, 0.5));
    EXPECT_EQ(imu[7].acc, Vec3(0.1 * 7, 0.25, 9.81));
    const auto images = only<ImageReading>(all);
    ASSERT_EQ(images.size(), 8u) << name;
    EXPECT_EQ(images[3].pixels.at<std::uint8_t>(10, 20), (60 + 50 + 21) & 255);
    const auto poses = only<StampedPose>(all);
    ASSERT_EQ(poses.size(), 40u) << name;
    // The pose is that of `base`; the IMU is 0.1 m above it.
    EXPECT_NEAR((poses[5].T_W_B.p - Vec3(0.05, 1, 2.1)).norm(), 0, 1e-12);
    const auto ranges = only<Range>(all);
    ASSERT_EQ(ranges.size(), 18u) << name;
    EXPECT_EQ(ranges[0].anchor, 0u);
    EXPECT_EQ(ranges[0].range_m, 2.5);
    EXPECT_EQ(ranges[0].sigma_m, 0.25);
    EXPECT_EQ(ranges[1].anchor, 0x84u);  // hexadecimal
    EXPECT_EQ(ranges[1].range_m, 1.0);
    EXPECT_EQ(ranges[1].t, kStart + 2 * kMs);
  }
}

TEST_F(Recording, ImagesAreResizedWithTheirCalibration) {
  {
    test::Ros1Writer bag(path());
    test::writeCameraInfo(bag, "/cam0/camera_info", kStart, 32, 24, "plumb_bob", {0, 0, 0, 0, 0},
                          30, 30, 16, 12);
    test::writeStatic(bag, kStart, {0, 0, 0}, {0, 0, 0, 1});
    for (int i = 0; i < 3; ++i) {
      const TimeNs t = kStart + i * 50 * kMs;
      test::writeImu(bag, "/imu", t, t, {0, 0, 0}, {0, 0, 9.81});
      test::writeImage(bag, "/cam0/image_raw", t, t, 32, 24, "mono8", 32,
                       std::vector<std::uint8_t>(32 * 24, 100));
    }
  }
  options.width_px = 16;
  options.need_calibration = false;
  const auto images = only<ImageReading>(readAll());
  ASSERT_EQ(images.size(), 3u);
  EXPECT_EQ(images[0].pixels.cols, 16);
  EXPECT_EQ(images[0].pixels.rows, 12);
  EXPECT_EQ(recording->cameras()[0].intrinsics.width, 16);
  EXPECT_TRUE(noted("are resized to 16x12"));
}

TEST_F(Recording, StampsOrTimesOfReceiptAsAsked) {
  {
    test::Ros1Writer bag(path());
    for (int i = 0; i < 10; ++i) {
      test::writeImu(bag, "/imu", kStart + i * 5 * kMs, kStart + i * 5 * kMs + 3 * kMs, {0, 0, 0},
                     {0, 0, 9.81});
    }
  }
  EXPECT_EQ(readAll().front().t, kStart);
  options.stamps = "received";
  EXPECT_EQ(readAll().front().t, kStart + 3 * kMs);
}

TEST_F(Recording, ClocksThatAreApartAreNoticed) {
  {
    test::Ros1Writer bag(path());
    for (int i = 0; i < 10; ++i) {
      const TimeNs t = kStart + i * 50 * kMs;
      test::writeImu(bag, "/imu", t - kStart + 1000 * kMs, t, {0, 0, 0}, {0, 0, 9.81});
      test::writeImage(bag, "/cam/image_raw", t, t, 4, 4, "mono8", 4,
                       std::vector<std::uint8_t>(16));
    }
  }
  options.need_calibration = false;
  options.source = path();
  const BagRecording r(options, &log);
  EXPECT_TRUE(noted("stamps = received")) << "said nothing";
}

TEST_F(Recording, ReadingsOutOfOrderAreSorted) {
  {
    test::Ros1Writer bag(path());
    for (int i = 0; i < 100; ++i) {
      // Images come 80 ms after their time.
      const TimeNs t = kStart + i * 50 * kMs;
      test::writeImage(bag, "/cam/image_raw", t - 80 * kMs, t, 4, 4, "mono8", 4,
                       std::vector<std::uint8_t>(16));
      test::writeImu(bag, "/imu", t, t, {0, 0, 0}, {0, 0, 9.81});
    }
  }
  options.need_calibration = false;
  EXPECT_EQ(readAll().size(), 200u);  // in order: readAll() looks
}

TEST_F(Recording, TwoStreamsOfAnImuAreOne) {
  {
    test::Ros1Writer bag(path());
    for (int i = 0; i < 400; ++i) {  // gyro 200 Hz, accelerometer 100 Hz, 1 ms apart
      const TimeNs t = kStart + i * 5 * kMs;
      test::writeImu(bag, "/camera/gyro/sample", t, t, {0.5, 0, 0}, {0, 0, 0});
      if (i % 2 == 0) {
        const TimeNs a = t + kMs;
        const double x = 1e-9 * static_cast<double>(a - kStart);
        test::writeImu(bag, "/camera/accel/sample", a, a, {0, 0, 0}, {x, 0, 9.81});
      }
    }
  }
  const auto imu = only<ImuSample>(readAll());
  ASSERT_GT(imu.size(), 390u);
  for (const ImuSample& s : imu) {
    EXPECT_EQ(s.gyro.x(), 0.5);
    EXPECT_NEAR(s.acc.x(), 1e-9 * static_cast<double>(s.t - kStart), 1e-9);
    EXPECT_NEAR(s.acc.z(), 9.81, 1e-12);
  }
}

/// As programs on phones write it: a type of their own with x, y, z and nothing around them.
TEST_F(Recording, BareVectorsOfAPhoneAreAnImu) {
  {
    test::Ros1Writer bag(path());
    bag.define("phone/Sample", "Header header\nfloat64 x\nfloat64 y\nfloat64 z\n");
    bag.define("phone/Bare", "float32 x\nfloat32 y\nfloat32 z\n");
    for (int i = 0; i < 100; ++i) {
      const TimeNs t = kStart + i * 5 * kMs;
      test::WireBytes gyro = bag.message();
      gyro.put(0.5F).put(0.25F).put(-1.0F);
      bag.write("/phone/gyroscope", "phone/Bare", gyro.bytes(), t);
      test::WireBytes acc = bag.message();
      acc.header(t, "phone").doubles(0.1, 0.2, 9.81);
      bag.write("/phone/accelerometer", "phone/Sample", acc.bytes(), t);
    }
  }
  for (const char* topics : {"", "accel=/phone/accelerometer gyro=/phone/gyroscope"}) {
    options.topics.clear();
    const auto imu = only<ImuSample>(readAll(topics));
    ASSERT_GT(imu.size(), 95u) << topics;
    EXPECT_EQ(imu[5].gyro, Vec3(0.5, 0.25, -1)) << topics;
    EXPECT_NEAR((imu[5].acc - Vec3(0.1, 0.2, 9.81)).norm(), 0, 1e-12) << topics;
  }
}

TEST_F(Recording, WhatIsWrongWithTheTopicsIsSaid) {
  {
    test::Ros1Writer bag(path());
    test::writeImu(bag, "/imu", kStart, kStart, {0, 0, 0}, {0, 0, 9.81});
    test::writeImage(bag, "/cam/image_raw", kStart, kStart, 4, 4, "mono8", 4,
                     std::vector<std::uint8_t>(16));
  }
  EXPECT_NE(complaint("camera=/nowhere").find("/cam/image_raw (sensor_msgs/Image)"),
            std::string::npos);
  EXPECT_NE(complaint("camera=/imu").find("sensor_msgs/Imu cannot be taken as camera"),
            std::string::npos);
  EXPECT_NE(complaint("eye=/imu").find("role"), std::string::npos);
  EXPECT_NE(complaint("range=/imu").find("anchor_id,distance"), std::string::npos);
  EXPECT_NE(complaint("camera=/cam/image_raw imu=/imu").find("--calibration FILE"),
            std::string::npos);
}

TEST_F(Recording, ACalibrationFileGoesBeforeTheRecording) {
  test::writeText(folder_ / "kalibr.yaml",
                  "cam0:\n"
                  "  T_cam_imu:\n"
                  "  - [0.0, 1.0, 0.0, 0.5]\n"
                  "  - [-1.0, 0.0, 0.0, 0.0]\n"
                  "  - [0.0, 0.0, 1.0, 0.0]\n"
                  "  - [0.0, 0.0, 0.0, 1.0]\n"
                  "  camera_model: pinhole\n"
                  "  distortion_coeffs: [0.01, 0.02, 0.03, 0.04]\n"
                  "  distortion_model: equidistant\n"
                  "  intrinsics: [33.0, 34.0, 15.0, 11.0]\n"
                  "  resolution: [32, 24]\n"
                  "  rostopic: /cam0/image_raw\n"
                  "  timeshift_cam_imu: 0.0125\n");
  BagOptions o;
  o.source = fixture("ros1_lz4.bag");
  o.calibration = (folder_ / "kalibr.yaml").string();
  const BagRecording r(o, &log);
  ASSERT_EQ(r.cameras().size(), 1u);
  const CameraSetup& c = r.cameras()[0];
  EXPECT_EQ(c.intrinsics.fx, 33);
  EXPECT_EQ(c.intrinsics.distortion, Distortion::equidistant);
  // T_cam_imu takes the IMU's coordinates to the camera's: the other way round here.
  EXPECT_NEAR((c.T_B_C.p - Vec3(0, -0.5, 0)).norm(), 0, 1e-12);
  EXPECT_NE(r.extras().ini.find("time_offset_s = 0.0125"), std::string::npos) << r.extras().ini;
  o.calibration = (folder_ / "nowhere.yaml").string();
  EXPECT_THROW(BagRecording(o, &log), std::runtime_error);
}

TEST_F(Recording, AllCamerasThatAreAskedForComeOthersAreNamed) {
  {
    test::Ros1Writer bag(path());
    for (const char* topic : {"/a/image_raw", "/b/image_raw"}) {
      test::writeImage(bag, topic, kStart, kStart, 4, 4, "mono8", 4, std::vector<std::uint8_t>(16));
    }
  }
  options.need_calibration = false;
  EXPECT_EQ(readAll().size(), 1u);
  EXPECT_TRUE(noted("/b/image_raw (sensor_msgs/Image) left out"));
  EXPECT_EQ(readAll("camera=/a/image_raw camera=/b/image_raw").size(), 2u);
  EXPECT_EQ(recording->streams()[1].label, "CAM1");
}

TEST_F(Recording, MessagesThatAreDamagedAreCountedAndLeftOut) {
  {
    test::Ros1Writer bag(path());
    test::writeImu(bag, "/imu", kStart, kStart, {0, 0, 0}, {0, 0, 9.81});
    bag.write("/imu", "sensor_msgs/Imu", {1, 2, 3}, kStart + kMs);
    test::writeImu(bag, "/imu", kStart + 2 * kMs, kStart + 2 * kMs, {NAN, 0, 0}, {0, 0, 9.81});
    test::writeImu(bag, "/imu", 0, kStart + 3 * kMs, {0, 0, 0}, {0, 0, 9.81});
  }
  EXPECT_EQ(readAll().size(), 2u);
  EXPECT_EQ(log.get("undecodable_IMU0"), 1);
  EXPECT_EQ(log.get("imu_not_finite"), 1);
  EXPECT_EQ(log.get("stamp_missing_IMU0"), 1);
}

TEST_F(Recording, UnitsOfTheImuThatAreNamedAreTaken) {
  {
    test::Ros1Writer bag(path());
    test::writeImu(bag, "/imu", kStart, kStart, {180, 0, -90}, {0, 0.5, 1});
  }
  options.acc_unit = "g";
  options.gyro_unit = "deg/s";
  const auto imu = only<ImuSample>(readAll());
  ASSERT_EQ(imu.size(), 1u);
  EXPECT_NEAR((imu[0].gyro - Vec3(3.14159265359, 0, -1.57079632679)).norm(), 0, 1e-9);
  EXPECT_NEAR((imu[0].acc - Vec3(0, 4.903325, 9.80665)).norm(), 0, 1e-9);
}

}  // namespace
}  // namespace vir::bag
