/// Folders of tables and images that nobody laid out for us.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "input_error.h"
#include "recording.h"
#include "table_folder.h"
#include "vir_test_temp_folder.h"

namespace vir::euroc {
namespace {

namespace fs = std::filesystem;

constexpr TimeNs kStart = 1700000000000000000;
constexpr int kImages = 8, kReadings = 80;

std::string seconds(TimeNs t) {
  char text[40];
  std::snprintf(text, sizeof text, "%.9f", static_cast<double>(t - kStart) * 1e-9 + 5.0);
  return text;
}

class CsvFolder : public ::testing::Test {
 protected:
  void images(const std::string& dir, const std::function<std::string(int, TimeNs)>& name) {
    fs::create_directories(root() / dir);
    for (int i = 0; i < kImages; ++i) {
      cv::imwrite((root() / dir / name(i, imageTime(i))).string(),
                  cv::Mat(48, 64, CV_8UC1, cv::Scalar(20 * i)));
    }
  }
  /// `line` of a time, for readings at 200 Hz.
  void table(const std::string& file, const std::string& header,
             const std::function<std::string(TimeNs)>& line) {
    std::string text = header;
    for (int i = 0; i < kReadings; ++i) text += line(kStart + i * 5'000'000) + "\n";
    fs::create_directories((root() / file).parent_path());
    test::writeText(root() / file, text);
  }
  void calibration() {
    test::writeText(
        root() / "camchain.yaml",
        "cam0:\n  camera_model: pinhole\n  intrinsics: [40, 41, 31, 23]\n"
        "  distortion_model: radtan\n  distortion_coeffs: [0, 0, 0, 0]\n"
        "  resolution: [64, 48]\n  T_cam_imu: [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]\n");
  }
  static TimeNs imageTime(int i) { return kStart + i * 50'000'000; }
  fs::path root() const { return temp_.path(); }

  struct Content {
    std::vector<ImuSample> imu;
    std::vector<RangeRow> ranges;
    std::vector<std::string> range_labels;
    std::vector<PoseRow> truth;
    std::vector<std::pair<TimeNs, std::string>> images;
    std::string notes;
    ProblemLog log;
  };
  Content read(const std::string& topics = "") {
    EurocOptions o;
    o.section = "csv";
    o.source = root().string();
    o.topics = topics;
    ProblemLog log;
    Recording recording(findTables(o), o, &log);
    Content c;
    Event e;
    while (recording.next(&e)) {
      if (auto* imu = std::get_if<ImuSample>(&e.what)) c.imu.push_back(*imu);
      if (auto* pose = std::get_if<PoseRow>(&e.what)) c.truth.push_back(*pose);
      if (auto* range = std::get_if<RangeRow>(&e.what)) {
        c.ranges.push_back(*range);
        c.range_labels.push_back(recording.rangeStreams()[e.stream].label);
      }
      if (auto* image = std::get_if<ImageRow>(&e.what)) {
        c.images.emplace_back(e.t, fs::path(image->file).filename().string());
      }
    }
    for (const std::string& m : log.messages()) c.notes += m + "\n";
    c.log = log;
    return c;
  }

  test::TempFolder temp_;
};

TEST_F(CsvFolder, TablesByHeaderAndImagesByList) {
  calibration();
  images("rgb", [](int i, TimeNs) { return std::to_string(i) + ".png"; });
  std::string list = "# timestamp filename\n";
  for (int i = 0; i < kImages; ++i) {
    list += seconds(imageTime(i)) + " rgb/" + std::to_string(i) + ".png\n";
  }
  test::writeText(root() / "rgb.txt", list);
  table("inertial.txt", "# timestamp ax ay az gx gy gz\n",
        [](TimeNs t) { return seconds(t) + " 0.1 0.2 9.8 0.01 0.02 0.03"; });
  table("gt.txt", "", [](TimeNs t) { return seconds(t) + " 1 2 3 0 0 0 1"; });
  const Content c = read();
  ASSERT_EQ(c.imu.size(), static_cast<std::size_t>(kReadings)) << c.notes;
  EXPECT_EQ(c.imu[1].t, 5'005'000'000);
  EXPECT_EQ(c.imu[1].acc, Vec3(0.1, 0.2, 9.8));
  EXPECT_EQ(c.imu[1].gyro, Vec3(0.01, 0.02, 0.03));
  ASSERT_EQ(c.images.size(), static_cast<std::size_t>(kImages));
  EXPECT_EQ(c.images[3].first, 5'150'000'000);
  EXPECT_EQ(c.images[3].second, "3.png");
  EXPECT_EQ(c.truth.size(), static_cast<std::size_t>(kReadings));
}

TEST_F(CsvFolder, ACalibrationWithoutASizeHasThatOfTheImages) {
  images("frames", [](int, TimeNs t) { return std::to_string(t) + ".png"; });
  table("imu.csv", "timestamp,ax,ay,az,gx,gy,gz\n",
        [](TimeNs t) { return std::to_string(t) + ",0,0,9.8,0,0,0"; });
  const std::string orb =
      "%YAML:1.0\nCamera.fx: 40\nCamera.fy: 41\nCamera.cx: 31\nCamera.cy: 23\n"
      "Tbc: !!opencv-matrix\n  rows: 4\n  cols: 4\n  dt: f\n"
      "  data: [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]\n";
  test::writeText(root() / "orb.yaml", orb);
  const Content c = read();
  EXPECT_EQ(c.images.size(), static_cast<std::size_t>(kImages));
  EXPECT_NE(c.notes.find("the size of the images, 64x48, taken from the first one"),
            std::string::npos)
      << c.notes;
  std::string other = orb;
  other.replace(other.find("cx: 31"), 6, "cx: 310");
  test::writeText(root() / "orb.yaml", other);
  try {
    read();
    FAIL();
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("64x48"), std::string::npos) << e.what();
  }
}

TEST_F(CsvFolder, APhonesTwoFilesInG) {
  calibration();
  images("frames", [](int, TimeNs t) { return "IMG_" + std::to_string(t / 1'000'000) + ".png"; });
  table("Accelerometer.csv", "time,seconds_elapsed,z,y,x\n", [](TimeNs t) {
    return std::to_string(t) + ",0,1.0,0.0,0." + std::to_string((t - kStart) / 5'000'000 + 10);
  });
  table("Gyroscope.csv", "time,seconds_elapsed,z,y,x\n",
        [](TimeNs t) { return std::to_string(t + 2'500'000) + ",0,0.3,0.2,0.1"; });
  table("Magnetometer.csv", "time,seconds_elapsed,z,y,x\n",
        [](TimeNs t) { return std::to_string(t) + ",0,3,2,1"; });
  const Content c = read();
  ASSERT_EQ(c.imu.size(), static_cast<std::size_t>(kReadings - 1)) << c.notes;
  EXPECT_EQ(c.imu[0].t, kStart + 2'500'000);
  EXPECT_EQ(c.imu[0].gyro, Vec3(0.1, 0.2, 0.3));
  EXPECT_NEAR(c.imu[0].acc.x(), 0.105 * 9.80665, 1e-9);  // in the middle of 0.10 and 0.11 g
  EXPECT_NEAR(c.imu[0].acc.z(), 9.80665, 1e-9);
  ASSERT_EQ(c.images.size(), static_cast<std::size_t>(kImages));
  EXPECT_EQ(c.images[2].first, imageTime(2));
  EXPECT_NE(c.notes.find("taken to be in g"), std::string::npos) << c.notes;
}

/// The numbers of an attitude look like a force in g, and like a quaternion in a table of poses.
TEST_F(CsvFolder, AnAttitudeWithAHeaderIsNeitherAnImuNorPoses) {
  calibration();
  images("cam", [](int i, TimeNs) { return std::to_string(i) + ".png"; });
  std::string list = "# timestamp filename\n";
  for (int i = 0; i < kImages; ++i) {
    list += seconds(imageTime(i)) + " cam/" + std::to_string(i) + ".png\n";
  }
  test::writeText(root() / "cam.txt", list);
  table("inertial.txt", "# timestamp ax ay az gx gy gz\n",
        [](TimeNs t) { return seconds(t) + " 0.1 0.2 9.8 0.01 0.02 0.03"; });
  table("orientation.csv", "time,seconds_elapsed,qz,qy,qx,qw,roll,pitch,yaw\n",
        [](TimeNs t) { return seconds(t) + ",1,0,0,0,1,0.1,0.2,0.3"; });
  const Content c = read();
  EXPECT_EQ(c.imu.size(), static_cast<std::size_t>(kReadings)) << c.notes;
  EXPECT_TRUE(c.truth.empty());
  EXPECT_NE(c.notes.find("orientation.csv: not read"), std::string::npos) << c.notes;
}

TEST_F(CsvFolder, CountedImagesWithAListOfStampsAndNoHeaderAtAll) {
  calibration();
  images("image_0", [](int i, TimeNs) {
    return std::string(i < 10 ? "00000" : "0000") + std::to_string(i) + ".png";
  });
  std::string times;
  for (int i = 0; i < kImages; ++i) times += seconds(imageTime(i)) + "\n";
  test::writeText(root() / "times.txt", times);
  table("imu.csv", "", [](TimeNs t) { return seconds(t) + ";0.1;0.2;9.8;0.01;0.02;0.03"; });
  table("uwb.csv", "time;anchor;distance (mm)\n",
        [](TimeNs t) { return seconds(t) + ";0x84;1500"; });
  table("tag2.csv", "timestamp,anchor_id,range_m\n",
        [](TimeNs t) { return seconds(t) + ",7,2.5"; });
  const Content c = read();
  ASSERT_EQ(c.images.size(), static_cast<std::size_t>(kImages)) << c.notes;
  EXPECT_EQ(c.images[5].second, "000005.png");
  EXPECT_EQ(c.images[5].first, 5'250'000'000);
  ASSERT_FALSE(c.imu.empty());
  EXPECT_EQ(c.imu[0].acc, Vec3(0.1, 0.2, 9.8));  // by the size of the numbers
  ASSERT_EQ(c.ranges.size(), static_cast<std::size_t>(2 * kReadings));
  EXPECT_EQ(c.range_labels[0], "UWB0");
  EXPECT_EQ(c.range_labels[1], "UWB1");
  EXPECT_DOUBLE_EQ(c.ranges[0].range_m, 2.5);
  EXPECT_DOUBLE_EQ(c.ranges[1].range_m, 1.5);
  EXPECT_EQ(c.ranges[1].anchor, 0x84);
}

TEST_F(CsvFolder, UnitsOfTheHeader) {
  table(
      "data.csv",
      "Timestamp (us),Gyro X (deg/s),Gyro Y (deg/s),Gyro Z (deg/s),Acc X (g),Acc Y (g),Acc Z (g)\n",
      [](TimeNs t) { return std::to_string(t / 1000) + ",180,0,90,0,0,1"; });
  const Content c = read();
  ASSERT_EQ(c.imu.size(), static_cast<std::size_t>(kReadings)) << c.notes;
  EXPECT_NEAR(c.imu[0].gyro.x(), 3.14159265358979, 1e-12);
  EXPECT_NEAR(c.imu[0].acc.z(), 9.80665, 1e-12);
  EXPECT_EQ(c.imu[3].t, kStart + 15'000'000);
}

TEST_F(CsvFolder, SecondsAndNanosecondsInTwoColumns) {
  table("imu.csv", "secs,nsecs,wx,wy,wz,ax,ay,az\n", [](TimeNs t) {
    return std::to_string(t / 1000000000) + "," + std::to_string(t % 1000000000) +
           ",0.1,0.2,0.3,0,0,9.8";
  });
  const Content c = read();
  ASSERT_EQ(c.imu.size(), static_cast<std::size_t>(kReadings));
  EXPECT_EQ(c.imu[1].t, kStart + 5'000'000);
  EXPECT_DOUBLE_EQ(c.imu[1].gyro.z(), 0.3);
}

TEST_F(CsvFolder, TablesThatAreNotReadAreSaid) {
  table("imu.csv", "t,wx,wy,wz,ax,ay,az\n",
        [](TimeNs t) { return std::to_string(t) + ",0.1,0.2,0.3,0,0,9.8"; });
  table("gps.csv", "t,latitude,longitude,altitude\n",
        [](TimeNs t) { return std::to_string(t) + ",47.1,8.2,400"; });
  EXPECT_NE(read().notes.find("gps.csv: not read"), std::string::npos) << read().notes;
  // As a truth it is refused in words.
  const Content c = read("truth=gps.csv");
  EXPECT_TRUE(c.truth.empty());
  EXPECT_EQ(c.log.get("ground_truth_no_pose"), kReadings);
}

TEST_F(CsvFolder, NamesOfImagesWithDateOrWithSecondsAndNanoseconds) {
  table("a.csv", "t,ax,ay,az,gx,gy,gz\n", [](TimeNs t) { return seconds(t) + ",0,0,9.8,0,0,0"; });
  calibration();
  const auto dated = [](TimeNs t, const char* format) {
    const std::time_t whole = t / 1'000'000'000;
    std::tm parts{};
    gmtime_r(&whole, &parts);
    char date[40], ms[8];
    std::strftime(date, sizeof date, format, &parts);
    std::snprintf(ms, sizeof ms, "%03d", static_cast<int>(t / 1'000'000 % 1000));
    return date + std::string(ms);
  };
  const std::vector<std::function<std::string(int, TimeNs)>> kinds{
      [&](int, TimeNs t) { return dated(t, "IMG_%Y%m%d_%H%M%S") + ".png"; },
      [&](int, TimeNs t) { return dated(t, "%Y-%m-%d_%H-%M-%S.") + ".png"; },
      [](int, TimeNs t) {
        const std::string ns = std::to_string(t);
        return ns.substr(0, 10) + "_" + ns.substr(10) + ".png";
      }};
  for (const auto& kind : kinds) {
    images("pictures", kind);
    const Content c = read();
    ASSERT_GT(c.images.size(), 2u) << c.notes;
    for (std::size_t i = 0; i < c.images.size(); ++i) {
      EXPECT_EQ(c.images[i].first, imageTime(static_cast<int>(i))) << c.images[i].second;
    }
    std::filesystem::remove_all(root() / "pictures");
  }
}

TEST_F(CsvFolder, WhatCannotBeToldIsAskedFor) {
  images("pictures", [](int i, TimeNs) { return std::to_string(i) + ".png"; });
  EXPECT_FALSE(isTableFolder(root().string()));
  table("a.csv", "t,ax,ay,az,gx,gy,gz\n", [](TimeNs t) { return seconds(t) + ",0,0,9.8,0,0,0"; });
  EXPECT_TRUE(isTableFolder(root().string()));
  const Content c = read();
  EXPECT_NE(c.notes.find("names hold no time"), std::string::npos) << c.notes;
  EXPECT_THROW(read("imu=b.csv"), InputError);
  EXPECT_THROW(read("wheel=a.csv"), InputError);
  EXPECT_THROW(read("camera=pictures"), InputError);  // no calibration, and no times
}

/// Before a clock's zero there is nothing that a rawlog could hold; the rest is read.
TEST_F(CsvFolder, TimesBeforeZeroAreLeftOutAndSaid) {
  std::string text = "t,ax,ay,az,gx,gy,gz\n";
  for (int i = -100; i < 100; ++i) text += std::to_string(0.005 * i) + ",0.1,0.2,9.8,0.01,0,0\n";
  test::writeText(root() / "imu.csv", text);
  const Content c = read();
  ASSERT_EQ(c.imu.size(), 100u) << c.notes;
  EXPECT_EQ(c.imu.front().t, 0);
  EXPECT_NE(c.notes.find("imu.csv:2: `-0.500000` is a time before 0; add the same to all stamps"),
            std::string::npos)
      << c.notes;
}

/// Whatever table they are in, quoted or not, and where only as many images as usable stamps exist.
TEST_F(CsvFolder, TimesBeforeZeroAreCountedInEveryTable) {
  calibration();
  images("rgb", [](int i, TimeNs) { return std::to_string(i) + ".png"; });
  const auto rows = [](const std::string& header, const std::string& quote, const std::string& rest,
                       int before, int after, double step) {
    std::string text = header;
    for (int i = -before; i < after; ++i) {
      text += quote + std::to_string(step * i) + quote + rest + "\n";
    }
    return text;
  };
  test::writeText(root() / "gyro.csv", rows("t,gx,gy,gz\n", "", ",0.1,0,0", 7, 100, 0.005));
  test::writeText(root() / "accel.csv", rows("", "\"", ",0.1,0.2,9.8", 6, 100, 0.005));
  test::writeText(root() / "uwb.csv", rows("t,anchor_id,range\n", "", ",1,2.5", 5, 20, 0.05));
  test::writeText(root() / "gt.csv", rows("t,x,y,z\n", "", ",1,2,3", 4, 20, 0.05));
  test::writeText(root() / "rgb" / "times.csv", rows("", "", "", 3, kImages, 0.05));
  const Content c = read("gyro=gyro.csv accel=accel.csv camera=rgb/times.csv");
  EXPECT_EQ(c.log.get("gyro_before_zero"), 7) << c.notes;
  EXPECT_EQ(c.log.get("accelerometer_before_zero"), 6) << c.notes;
  EXPECT_EQ(c.log.get("range_before_zero"), 5) << c.notes;
  EXPECT_EQ(c.log.get("ground_truth_before_zero"), 4) << c.notes;
  EXPECT_EQ(c.log.get("image_before_zero"), 3) << c.notes;
  EXPECT_EQ(c.images.size(), static_cast<std::size_t>(kImages)) << c.notes;
  EXPECT_NE(c.notes.find("times.csv:1: `-0.150000` is a time before 0"), std::string::npos)
      << c.notes;
}

TEST_F(CsvFolder, AGyroAloneIsNoImu) {
  table("gyro.csv", "t,gyro_x,gyro_y,gyro_z\n", [](TimeNs t) { return seconds(t) + ",0,0,0"; });
  EXPECT_THROW(read(), InputError);
}

TEST_F(CsvFolder, FilesThatAreNoTablesAreLeftAlone) {
  test::writeText(root() / "README.txt", "This is a recording.\n2 sensors, 3 anchors, nice\n");
  test::writeText(root() / "empty.csv", "");
  EXPECT_FALSE(isTableFolder(root().string()));
  EXPECT_FALSE(isTableFolder((root() / "README.txt").string()));
}

TEST_F(CsvFolder, UnknownNamesAreTakenByUnitOrByPositionAndSaid) {
  const auto milli = [](TimeNs t) { return std::to_string((t - kStart) / 1'000'000 + 1000); };
  table("imu.csv",
        "Zeit [ms];Beschl X [g];Beschl Y [g];Beschl Z [g];Drehrate X [\xB0/s];Drehrate Y "
        "[\xB0/s];Drehrate Z [\xB0/s]\n",
        [&](TimeNs t) { return milli(t) + ";0,01;0,02;1,0;90,0;0,0;0,0"; });
  table("uwb.csv", "Zeit [ms];Anker;Entfernung [cm]\n",
        [&](TimeNs t) { return milli(t) + ";3;250"; });
  const Content c = read();
  ASSERT_EQ(c.imu.size(), static_cast<std::size_t>(kReadings)) << c.notes;
  EXPECT_NEAR(c.imu[0].acc.z(), 9.80665, 1e-9);
  EXPECT_NEAR(c.imu[0].gyro.x(), M_PI / 2, 1e-9);
  ASSERT_EQ(c.ranges.size(), static_cast<std::size_t>(kReadings)) << c.notes;
  EXPECT_NEAR(c.ranges[0].range_m, 2.5, 1e-9);
  EXPECT_NE(c.notes.find("taken by their units: Zeit [ms] as stamp, Drehrate X [\xC2\xB0/s] as "
                         "gyro x"),
            std::string::npos)
      << c.notes;
  EXPECT_NE(c.notes.find("taken by position: Zeit [ms] as stamp, Anker as anchor, Entfernung [cm] "
                         "as range"),
            std::string::npos)
      << c.notes;
  EXPECT_EQ(c.log.get("table_by_position"), 1);
}

TEST_F(CsvFolder, AnyYamlWithIntrinsicsIsTaken) {
  images("frames", [](int, TimeNs t) { return std::to_string(t) + ".png"; });
  table("imu.csv", "timestamp,ax,ay,az,gx,gy,gz\n",
        [](TimeNs t) { return std::to_string(t) + ",0,0,9.8,0,0,0"; });
  const std::string euroc =
      "T_BS:\n  cols: 4\n  rows: 4\n  data: [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]\n"
      "resolution: [64, 48]\ncamera_model: pinhole\nintrinsics: [40, 41, 31, 23]\n"
      "distortion_model: radial-tangential\ndistortion_coefficients: [0, 0, 0, 0]\n";
  EXPECT_THROW(read(), InputError);
  // Of another camera.
  fs::create_directories(root() / "right");
  test::writeText(root() / "right" / "sensor.yaml", euroc);
  EXPECT_THROW(read(), InputError);
  test::writeText(root() / "sensor.yaml", euroc);
  EXPECT_EQ(read().images.size(), static_cast<std::size_t>(kImages));
  calibration();
  fs::rename(root() / "camchain.yaml", root() / "sensor.yaml");
  EXPECT_EQ(read().images.size(), static_cast<std::size_t>(kImages));
  // Without a pose a run finds it.
  test::writeText(root() / "sensor.yaml", euroc.substr(euroc.find("resolution")));
  EXPECT_NE(read().notes.find("its pose on the IMU is not given"), std::string::npos);
}

}  // namespace
}  // namespace vir::euroc
