/// A bag as readings in time order: roles, stamps, what is wrong with messages.
#include <gtest/gtest.h>

#include "bag_recording.h"
#include "input_error.h"
#include "vir_test_bag_writer.h"
#include "vir_test_paths.h"
#include "vir_test_temp_folder.h"

namespace vir::bag {
namespace {

constexpr TimeNs kMs = 1'000'000;
const TimeNs kStart = 1'600'000'000LL * 1'000 * kMs;

class Recording : public testing::Test {
 protected:
  std::string path() const { return (folder_ / "x.bag").string(); }

  std::vector<Reading> readAll(const std::string& topics = "") {
    options.source = path();
    if (!topics.empty()) options.topics = topics;
    log = {};
    recording = std::make_unique<BagRecording>(options, &log);
    std::vector<Reading> out;
    for (Reading r; recording->next(&r);) out.push_back(std::move(r));
    for (std::size_t i = 1; i < out.size(); ++i) EXPECT_LE(out[i - 1].t, out[i].t);
    return out;
  }
  std::string complaint(const std::string& topics = "") {
    try {
      readAll(topics);
      return "";
    } catch (const std::runtime_error& e) {
      return e.what();
    }
  }
  bool noted(const std::string& text) const {
    for (const std::string& m : log.messages()) {
      if (m.find(text) != std::string::npos) return true;
    }
    return false;
  }
  template <typename T>
  static std::vector<T> only(const std::vector<Reading>& readings, TimeNs* first = nullptr) {
    std::vector<T> out;
    for (const Reading& r : readings) {
      if (const T* x = std::get_if<T>(&r.what)) {
        if (out.empty() && first != nullptr) *first = r.t;
        out.push_back(*x);
      }
    }
    return out;
  }

  test::TempFolder folder_;
  BagOptions options;
  ProblemLog log;
  std::unique_ptr<BagRecording> recording;
};

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

TEST_F(Recording, RangesOfATypeNobodyKnowsByTheNamesOfItsFields) {
  {
    test::Ros1Writer bag(path());
    bag.define("some_driver/UwbRange", "Header header\nuint16 anchor_id\nuint32 distance\n");
    bag.define("other/UwbScan", "Header header\nMeasurement[] all\n" + std::string(80, '=') +
                                    "\nMSG: other/Measurement\nstring id\nfloat64 range_m\n");
    bag.define("cf_msgs/Tdoa", "Header header\nint32 idA\nint32 idB\nfloat32 data\n");
    test::WireBytes one = bag.message();
    one.header(kStart, "tag").put(std::uint16_t{7}).put(std::uint32_t{2500});
    bag.write("/a", "some_driver/UwbRange", one.bytes(), kStart);
    test::WireBytes list = bag.message();
    list.header(kStart + kMs, "tag").put(std::uint32_t{1}).text("0x84").put(3.5);
    bag.write("/b", "other/UwbScan", list.bytes(), kStart + kMs);
    test::WireBytes difference = bag.message();
    difference.header(kStart, "tag").put(1).put(2).put(0.5F);
    bag.write("/tdoa", "cf_msgs/Tdoa", difference.bytes(), kStart);
  }
  const auto ranges = only<Range>(readAll());
  ASSERT_EQ(ranges.size(), 2u);
  EXPECT_EQ(ranges[0].anchor, 7u);
  EXPECT_EQ(ranges[0].range_m, 2.5);  // whole numbers are millimetres
  EXPECT_EQ(ranges[1].anchor, 0x84u);
  EXPECT_EQ(ranges[1].range_m, 3.5);
  EXPECT_TRUE(noted("by the names of its fields, anchor_id,distance,unit=mm"));
  EXPECT_TRUE(noted("differences of ranges"));
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

TEST_F(Recording, RangesByTheNamesOfTheirFields) {
  {
    test::Ros1Writer bag(path());
    bag.define("my/Range", "time when\nuint64 who\nfloat64 cm\nfloat32 sd\n");
    bag.define("nlink_parser/LinktrackNodeframe3",
               "uint8 role\nuint8 id\nuint32 local_time\nuint32 system_time\nfloat32 voltage\n"
               "LinktrackNode2[] nodes\n===\nMSG: nlink_parser/LinktrackNode2\nuint8 role\n"
               "uint8 id\nfloat32 dis\nfloat32 fp_rssi\nfloat32 rx_rssi\n");
    test::WireBytes m = bag.message();
    m.put(std::uint32_t{1'600'000'001}).put(std::uint32_t{5});
    m.put(std::uint64_t{0xDECA0123456789AB}).put(250.0).put(0.5f);
    bag.write("/r", "my/Range", m.bytes(), kStart);
    test::WireBytes n = bag.message();
    n.put(std::uint8_t{0}).put(std::uint8_t{9}).put(0u).put(0u).put(5.f).put(2u);
    for (int i = 0; i < 2; ++i) {
      n.put(std::uint8_t{1}).put(static_cast<std::uint8_t>(3 + i)).put(1.5f + i).put(0.f).put(0.f);
    }
    bag.write("/nodes", "nlink_parser/LinktrackNodeframe3", n.bytes(), kStart);
  }
  auto ranges = only<Range>(readAll("range=/r:who,cm,unit=cm,stamp=when,sigma=sd"));
  ASSERT_EQ(ranges.size(), 1u);
  EXPECT_EQ(ranges[0].range_m, 2.5);
  EXPECT_EQ(ranges[0].sigma_m, 0.5);
  EXPECT_EQ(ranges[0].t, 1'600'000'001LL * 1'000 * kMs + 5);
  EXPECT_EQ(ranges[0].anchor, 1'000'000u);
  EXPECT_EQ(recording->anchors().mapped().begin()->first,
            std::to_string(std::uint64_t{0xDECA0123456789AB}));
  EXPECT_TRUE(noted("has the number 1000000"));
  ranges = only<Range>(readAll("range=/nodes"));
  ASSERT_EQ(ranges.size(), 2u);
  EXPECT_EQ(ranges[1].anchor, 4u);
  EXPECT_EQ(ranges[1].range_m, 2.5);
  EXPECT_EQ(ranges[1].t, kStart);  // no stamp: as received
}

TEST_F(Recording, RangesOfPackagesNamedUwbMsgsAreFoundByTheNamesOfTheirFields) {
  {
    test::Ros1Writer bag(path());
    // One message a range, without a header.
    bag.define("uwb_msgs/Range",
               "time stamp\nstring anchorid\nstring listenerid\nbool valid_range\n"
               "float32 distance\n");
    for (const bool valid : {true, false}) {
      test::WireBytes m = bag.message();
      m.put(std::uint32_t{1'600'000'001}).put(std::uint32_t{7}).text("anchor_2").text("tag");
      m.put(static_cast<std::uint8_t>(valid)).put(3.25f);
      bag.write("/uwb", "uwb_msgs/Range", m.bytes(), kStart);
    }
    // Two lists side by side, anchors by name.
    bag.define("uwb_msgs/Ranges",
               "Header header\nstring mobile\nstring[] anchors\nfloat64[] data\n===\n"
               "MSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n");
    test::WireBytes n = bag.message();
    n.put(0u).put(std::uint32_t{1'600'000'002}).put(0u).text("").text("tag").put(2u);
    n.text("anchor_2").text("0x10").put(2u).put(1.5).put(2.5);
    bag.write("/uwb/all", "uwb_msgs/Ranges", n.bytes(), kStart);
    // No ranges.
    bag.define("cf_msgs/Tdoa", "time stamp\nint8 idA\nint8 idB\nfloat32 data\n");
    bag.write(
        "/tdoa_data", "cf_msgs/Tdoa",
        bag.message().put(0u).put(0u).put(std::uint8_t{1}).put(std::uint8_t{2}).put(1.f).bytes(),
        kStart);
  }
  const auto ranges = only<Range>(readAll());
  ASSERT_EQ(ranges.size(), 3u);
  EXPECT_EQ(ranges[0].range_m, 3.25);
  EXPECT_EQ(ranges[0].t, 1'600'000'001LL * 1'000 * kMs + 7);
  EXPECT_EQ(ranges[1].range_m, 1.5);
  EXPECT_EQ(ranges[1].anchor, ranges[0].anchor);  // the same name
  EXPECT_EQ(ranges[2].range_m, 2.5);
  EXPECT_EQ(ranges[2].anchor, 16u);
  EXPECT_TRUE(noted("anchorid,distance,stamp=stamp,valid=valid_range"));
  EXPECT_TRUE(noted("by the names of its fields, anchors,data"));
  EXPECT_TRUE(noted("/tdoa_data (cf_msgs/Tdoa) left out: differences of ranges"));
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

}  // namespace
}  // namespace vir::bag
