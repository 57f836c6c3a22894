/// What export writes says the same as the rawlog; EuRoC's layout comes back through import.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "vir/rawlog/rawlog_reader.h"
#include "vir_test_paths.h"
#include "vir_test_rawlog.h"
#include "vir_test_shell.h"
#include "vir_test_temp_folder.h"

namespace vir {
namespace {

using test::kMs;
using test::kStart;
using test::Outcome;
using test::quoted;
using test::virSlam;

class ExportCli : public testing::Test {
 protected:
  void SetUp() override {
    rawlog::RawlogWriter writer(path("a.rawlog"));
    for (int i = 0; i < 40; ++i) {
      const TimeNs t = kStart + 5 * i * kMs;
      auto imu = test::imuAt(t);
      for (const auto index : {mrpt::obs::IMU_X_ACC, mrpt::obs::IMU_Y_ACC})
        imu->set(index, 0.1 * i);
      imu->set(mrpt::obs::IMU_WX, 1.0 / 3);
      imu->set(mrpt::obs::IMU_WY, -2e-7);
      imu->set(mrpt::obs::IMU_WZ, 0.25);
      writer.write(*imu);
      if (i % 10 != 5) continue;
      auto image = test::imageAt(t, i);
      image->cameraParams.ncols = 16;
      image->cameraParams.nrows = 12;
      image->cameraParams.setIntrinsicParamsFromValues(10, 11, 8, 6);
      image->cameraParams.setDistortionKannalaBrandt(0.1, -0.2, 0.3, -0.4);
      image->cameraPose = mrpt::poses::CPose3D(0.1, 0.2, 0.3, 0.4, 0.5, 0.6);
      writer.write(*image);
      writer.write(*test::truthAt(t, 0.1 * i));
      auto range = test::rangeAt(t + kMs, 4);
      range->stdError = 0.05F;
      range->sensedData[0].sensedDistance = 2.7F;
      range->sensedData[0].sensorLocationOnRobot.z(0.25);
      writer.write(*range);
    }
    writer.finish();
  }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  Outcome exportAs(const std::string& format) {
    return virSlam("export " + quoted(path("a.rawlog")) + " --format " + format + " --out " +
                   quoted(path(format)));
  }
  static long lines(const std::string& text) { return std::count(text.begin(), text.end(), '\n'); }

  test::TempFolder folder_;
};

std::vector<mrpt::obs::CObservation::Ptr> readAll(const std::string& path) {
  rawlog::RawlogReader reader(path);
  std::vector<mrpt::obs::CObservation::Ptr> all;
  while (auto o = reader.next()) all.push_back(o);
  EXPECT_EQ(reader.damage(), "");
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) {
    return std::make_pair(a->timestamp, a->sensorLabel) <
           std::make_pair(b->timestamp, b->sensorLabel);
  });
  return all;
}

void expectSame(mrpt::obs::CObservation& a, mrpt::obs::CObservation& b) {
  EXPECT_EQ(a.timestamp, b.timestamp);
  EXPECT_EQ(a.sensorLabel, b.sensorLabel);
  if (auto* imu = dynamic_cast<mrpt::obs::CObservationIMU*>(&a)) {
    EXPECT_EQ(imu->rawMeasurements, dynamic_cast<mrpt::obs::CObservationIMU&>(b).rawMeasurements);
  } else if (auto* image = dynamic_cast<mrpt::obs::CObservationImage*>(&a)) {
    auto& other = dynamic_cast<mrpt::obs::CObservationImage&>(b);
    image->load();
    other.load();
    EXPECT_EQ(image->image.at<std::uint8_t>(0, 0), other.image.at<std::uint8_t>(0, 0));
    EXPECT_EQ(image->cameraParams.dist, other.cameraParams.dist);
    EXPECT_EQ(image->cameraParams.distortion, other.cameraParams.distortion);
    EXPECT_EQ(image->cameraParams.fy(), other.cameraParams.fy());
    EXPECT_LT((image->cameraPose - other.cameraPose).norm(), 1e-9);
  } else if (auto* range = dynamic_cast<mrpt::obs::CObservationBeaconRanges*>(&a)) {
    auto& other = dynamic_cast<mrpt::obs::CObservationBeaconRanges&>(b);
    EXPECT_EQ(range->stdError, other.stdError);
    ASSERT_EQ(other.sensedData.size(), 1u);
    EXPECT_EQ(range->sensedData[0].sensedDistance, other.sensedData[0].sensedDistance);
    EXPECT_EQ(range->sensedData[0].beaconID, other.sensedData[0].beaconID);
    EXPECT_EQ(range->sensedData[0].sensorLocationOnRobot.z(),
              other.sensedData[0].sensorLocationOnRobot.z());
  }
}

TEST_F(ExportCli, EurocComesBackThroughImport) {
  const Outcome out = exportAs("euroc");
  ASSERT_EQ(out.code, 0) << out.text;
  const Outcome back =
      virSlam("import euroc " + quoted(path("euroc")) + " --out " + quoted(path("b.rawlog")));
  ASSERT_EQ(back.code, 0) << back.text;
  const auto before = readAll(path("a.rawlog"));
  const auto after = readAll(path("b.rawlog"));
  ASSERT_EQ(before.size(), after.size()) << back.text;
  for (std::size_t i = 0; i < before.size(); ++i) expectSame(*before[i], *after[i]);
}

/// A recording with one image named `name` and a pose labelled `label`.
class HostileExport : public ExportCli {
 protected:
  void write(const std::string& name, const std::string& label) {
    rawlog::RawlogWriter writer(path("a.rawlog"));
    auto image = test::imageAt(kStart);
    image->image.setExternalStorage(name);
    writer.write(*image);
    auto pose = test::truthAt(kStart, 1);
    pose->sensorLabel = label;
    writer.write(*pose);
    writer.finish();
  }
  std::vector<std::string> filesOf(const std::string& folder) const {
    std::vector<std::string> names;
    for (const auto& e : std::filesystem::directory_iterator(folder_ / folder)) {
      names.push_back(e.path().filename().string());
    }
    std::sort(names.begin(), names.end());
    return names;
  }
};

TEST_F(HostileExport, ALabelIsNoWayOut) {
  write("x.png", "..");
  ASSERT_EQ(exportAs("tum").code, 0);
  EXPECT_EQ(filesOf("tum"), std::vector<std::string>{"__.tum"});
  write("x.png", ".hidden");
  ASSERT_EQ(exportAs("csv").code, 0);
  EXPECT_EQ(filesOf("csv"), (std::vector<std::string>{"CAM0.csv", "_hidden.csv"}));
}

TEST_F(HostileExport, NamesOfImagesAreCellsOfATable) {
  write("=cmd|calc!A1,\"x\"\n.png", "GT");
  ASSERT_EQ(exportAs("csv").code, 0);
  const std::string text = test::readText(path("csv/CAM0.csv"));
  EXPECT_EQ(lines(text), 2);
  EXPECT_TRUE(test::contains(text, ",\"./=cmd|calc!A1,\"\"x\"\"_.png\"\n")) << text;
}

TEST_F(HostileExport, NothingElseIsCopiedAndThatIsAFailure) {
  test::writeText(folder_ / "secret.png", "secret");
  write("../secret.png", "GT");
  std::filesystem::create_directories(folder_ / "a_Images");
  const Outcome out = exportAs("euroc");
  EXPECT_EQ(out.code, 1) << out.text;
  EXPECT_TRUE(test::contains(out.text, "1 images were refused: '../secret.png' leads out"))
      << out.text;
  EXPECT_TRUE(test::contains(out.text, "1 images were left out")) << out.text;
  EXPECT_EQ(test::shell("grep -rl secret " + quoted(path("euroc"))).code, 1);
  // Beside the recording, but no image: not copied as it is either.
  std::filesystem::rename(folder_ / "secret.png", folder_ / "a_Images/secret.png");
  write("secret.png", "GT");
  std::filesystem::remove_all(folder_ / "euroc");
  EXPECT_EQ(exportAs("euroc").code, 1);
  EXPECT_EQ(test::shell("grep -rl secret " + quoted(path("euroc"))).code, 1);
}

TEST_F(HostileExport, AFifoDoesNotHang) {
  write("pipe.png", "GT");
  ASSERT_EQ(test::shell("mkdir " + quoted(path("a_Images")) + " && mkfifo " +
                        quoted(path("a_Images/pipe.png")))
                .code,
            0);
  const Outcome out =
      test::shell("timeout -k 1 20 " + quoted(test::buildDir() + "/bin/vir-slam") + " export " +
                  quoted(path("a.rawlog")) + " --format euroc --out " + quoted(path("euroc")));
  EXPECT_EQ(out.code, 1) << out.text;
  EXPECT_TRUE(test::contains(out.text, "'pipe.png' is no file")) << out.text;
}

/// Holds the lock of a folder or file while `command` runs.
Outcome whileLocked(const std::string& what, const std::string& command) {
  return test::shell("flock " + quoted(what) + " " + command);
}

TEST_F(ExportCli, TwoProgramsDoNotWriteTheSame) {
  const std::string program = quoted(test::buildDir() + "/bin/vir-slam");
  std::filesystem::create_directories(path("csv"));
  const Outcome exported =
      whileLocked(path("csv"), program + " export " + quoted(path("a.rawlog")) +
                                   " --format csv --out " + quoted(path("csv")));
  EXPECT_EQ(exported.code, 1) << exported.text;
  EXPECT_TRUE(test::contains(exported.text, "another process is writing")) << exported.text;
  EXPECT_TRUE(std::filesystem::is_empty(path("csv")));
  ASSERT_EQ(exportAs("euroc").code, 0);
  const std::string import =
      program + " import euroc " + quoted(path("euroc")) + " --out " + quoted(path("b.rawlog"));
  const Outcome imported = whileLocked(path(".b.rawlog.lock"), import);
  EXPECT_EQ(imported.code, 1) << imported.text;
  EXPECT_TRUE(test::contains(imported.text, "another process is writing")) << imported.text;
  EXPECT_FALSE(std::filesystem::exists(path("b.rawlog")));
  EXPECT_EQ(test::shell(import).code, 0);
  EXPECT_FALSE(std::filesystem::exists(path(".b.rawlog.lock"))) << "gone with who had it";
  // Of two at once one writes everything, or both do one after the other.
  const Outcome both = test::shell("(" + import + " & " + import + " & wait)");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(path("b_Images")), {}), 4);
}

TEST_F(ExportCli, EurocDoesNotOverwrite) {
  ASSERT_EQ(exportAs("euroc").code, 0);
  const Outcome again = exportAs("euroc");
  EXPECT_EQ(again.code, 1);
  EXPECT_TRUE(test::contains(again.text, "exists already")) << again.text;
}

TEST_F(ExportCli, McapComesBackThroughImport) {
  const Outcome out = exportAs("mcap");
  ASSERT_EQ(out.code, 0) << out.text;
  const Outcome back =
      virSlam("import " + quoted(path("mcap")) + " --out " + quoted(path("b.rawlog")));
  ASSERT_EQ(back.code, 0) << back.text;
  const auto before = readAll(path("a.rawlog"));
  const auto after = readAll(path("b.rawlog"));
  ASSERT_EQ(before.size(), after.size()) << back.text;
  for (std::size_t i = 0; i < before.size(); ++i) expectSame(*before[i], *after[i]);
}

/// What every kind of range and broadcast is beside an anchor's: by labels (docs/recordings.md).
TEST_F(ExportCli, McapBringsBackRobotsAnchorsAndAllCameras) {
  {
    rawlog::RawlogWriter writer(path("a.rawlog"));
    for (int i = 0; i < 6; ++i) {
      const TimeNs t = kStart + 50 * i * kMs;
      auto imu = test::imuAt(t);
      for (const auto index : {mrpt::obs::IMU_X_ACC, mrpt::obs::IMU_Y_ACC, mrpt::obs::IMU_WX,
                               mrpt::obs::IMU_WY, mrpt::obs::IMU_WZ}) {
        imu->set(index, 0.1 * i);
      }
      writer.write(*imu);
      for (const int camera : {0, 1}) {
        auto image = test::imageAt(t, i);
        image->sensorLabel = "CAM" + std::to_string(camera);
        image->cameraParams.ncols = 16;
        image->cameraParams.nrows = 12;
        image->cameraParams.setIntrinsicParamsFromValues(10 + camera, 11, 8, 6);
        image->cameraPose = mrpt::poses::CPose3D(0.1, 0.2 - 0.11 * camera, 0.3, 0.4, 0.5, 0.6);
        writer.write(*image);
      }
      const auto range = [&](const char* label, int to, float m, int ms) {
        auto r = test::rangeAt(t + ms * kMs, to);
        r->sensorLabel = label;
        r->stdError = 0.05F;
        r->sensedData[0].sensedDistance = m;
        writer.write(*r);
      };
      range("UWB0", 4, 2.5F, 1);
      range("UWB1", 4, 2.75F, 2);
      range("PEER", 7, 3.5F, 3);
      range("ANCHOR:4", 5, 6.25F, 4);
      for (const char* label : {"PEER:7", "PEER:7:ANCHOR:4", "PEER:7:WORLD:2", "ANCHOR:9"}) {
        auto pose = test::truthAt(t, 0.1 * i);
        pose->sensorLabel = label;
        for (int k = 0; k < 9; ++k) pose->pose.cov(k / 3, k % 3) = k % 4 == 0 ? 0.04 : 0.001;
        if (label == std::string("PEER:7:WORLD:2")) pose->sensorPose.z(0.3);
        writer.write(*pose);
      }
    }
    writer.finish();
  }
  ASSERT_EQ(exportAs("mcap").code, 0);
  const Outcome back =
      virSlam("import " + quoted(path("mcap")) + " --out " + quoted(path("b.rawlog")));
  ASSERT_EQ(back.code, 0) << back.text;
  const auto before = readAll(path("a.rawlog"));
  const auto after = readAll(path("b.rawlog"));
  ASSERT_EQ(before.size(), 6u * 11u);
  ASSERT_EQ(before.size(), after.size()) << back.text;
  for (std::size_t i = 0; i < before.size(); ++i) {
    expectSame(*before[i], *after[i]);
    const auto* told = dynamic_cast<mrpt::obs::CObservationRobotPose*>(before[i].get());
    if (told == nullptr) continue;
    const auto& other = dynamic_cast<mrpt::obs::CObservationRobotPose&>(*after[i]);
    EXPECT_EQ(told->pose.cov, other.pose.cov) << told->sensorLabel;
    EXPECT_EQ(told->sensorPose.z(), other.sensorPose.z()) << told->sensorLabel;
    EXPECT_LT((told->pose.mean - other.pose.mean).norm(), 1e-9) << told->sensorLabel;
  }
}

TEST_F(ExportCli, TheAuthorsOfMcapReadOurs) {
  if (std::system("node -e 'require(\"@mcap/core\")' >/dev/null 2>&1") != 0) {
    GTEST_SKIP() << "node with @mcap/core is not here (npm install @mcap/core, NODE_PATH)";
  }
  ASSERT_EQ(exportAs("mcap").code, 0);
  const std::string command = "node " +
                              quoted(test::sourceDir() + "/tests/fixtures/bags/read_mcap.cjs") +
                              " " + quoted(path("mcap")) + " > " + quoted(path("log")) + " 2>&1";
  EXPECT_EQ(std::system(command.c_str()), 0);
  const std::string text = test::readText(path("log"));
  for (const char* line :
       {"/imu0 sensor_msgs/msg/Imu 40", "/cam0/image_raw sensor_msgs/msg/Image 4",
        "/cam0/camera_info sensor_msgs/msg/CameraInfo 4", "/gt geometry_msgs/msg/PoseStamped 4",
        "/uwb0 vir_slam/msg/Range 4", "/tf_static tf2_msgs/msg/TFMessage 1", "total 57"}) {
    EXPECT_TRUE(test::contains(text, line)) << line << "\n" << text;
  }
}

TEST_F(ExportCli, ARunAsMcap) {
  const std::string run = path("run");
  std::filesystem::create_directories(run);
  test::writeText(run + "/trajectory.tum",
                  "1700000000.0 1 2 3 0 0 0 1\n1700000000.1 2 2 3 0 0 0 1\n");
  test::writeText(run + "/anchors.csv",
                  "id,x,y,z,cov_xx,cov_xy,cov_xz,cov_yx,cov_yy,cov_yz,cov_zx,cov_zy,cov_zz,state\n"
                  "7,1,2,3,0.01,0,0,0,0.04,0,0,0,0.09,Located\n");
  test::writeText(run + "/landmarks.ply",
                  "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
                  "property float z\nend_header\n1 2 3\n4 5 6\n");
  const Outcome out =
      virSlam("export " + quoted(run) + " --format mcap --out " + quoted(path("r")));
  ASSERT_EQ(out.code, 0) << out.text;
  const Outcome list = virSlam("import " + quoted(path("r")) + " --list");
  EXPECT_EQ(list.code, 0) << list.text;
  for (const char* part : {"nav_msgs/Odometry", "visualization_msgs/MarkerArray",
                           "sensor_msgs/PointCloud2", "tf2_msgs/TFMessage"}) {
    EXPECT_TRUE(test::contains(list.text, part)) << list.text;
  }
  EXPECT_FALSE(test::contains(list.text, "problem")) << list.text;
  EXPECT_EQ(virSlam("export " + quoted(run) + " --format tum --out " + quoted(path("t"))).code, 2);
}

TEST_F(ExportCli, Tum) {
  const Outcome out = exportAs("tum");
  ASSERT_EQ(out.code, 0) << out.text;
  const std::string text = test::readText(path("tum/GT.tum"));
  EXPECT_EQ(lines(text), 4);
  EXPECT_EQ(text.substr(0, text.find('\n')),
            "1700000000.025000000 0.500000000 0.000000000 0.000000000 0.000000000 0.000000000 "
            "0.000000000 1.000000000");
}

TEST_F(ExportCli, Csv) {
  const Outcome out = exportAs("csv");
  ASSERT_EQ(out.code, 0) << out.text;
  EXPECT_EQ(lines(test::readText(path("csv/IMU0.csv"))), 41);
  EXPECT_EQ(lines(test::readText(path("csv/CAM0.csv"))), 5);
  EXPECT_TRUE(test::contains(test::readText(path("csv/UWB0.csv")),
                             "\n1700000000026000000,4,2.7,0.05,0,0,0.25\n"));
}

TEST_F(ExportCli, DamagedRecordingIsExportedAndReported) {
  const std::string whole = test::readText(path("a.rawlog"));
  test::writeText(path("a.rawlog"), whole.substr(0, whole.size() * 2 / 3));
  const Outcome out = exportAs("csv");
  EXPECT_EQ(out.code, 1);
  EXPECT_TRUE(test::contains(out.text, "damaged or cut off")) << out.text;
  EXPECT_TRUE(std::filesystem::exists(path("csv/IMU0.csv")));
}

TEST_F(ExportCli, WrongUse) {
  EXPECT_EQ(exportAs("pcd").code, 2);
  EXPECT_EQ(virSlam("export /nowhere.rawlog --format csv --out x").code, 2);
}

}  // namespace
}  // namespace vir
