/// The sensor as it is used: loaded as a plugin, asked for observations.
#include <gtest/gtest.h>
#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/obs/CObservationBeaconRanges.h>
#include <mrpt/obs/CObservationRobotPose.h>

#include "vir/rawlog/mrpt_time.h"
#include "vir/roles/plugin_loader.h"
#include "vir/roles/recorded_source.h"
#include "vir/roles/sensor_registry.h"
#include "vir_test_paths.h"
#include "vir_test_pyfg.h"
#include "vir_test_temp_folder.h"

namespace vir {
namespace {

using namespace mrpt::obs;

struct Content {
  std::vector<CObservationRobotPose::Ptr> poses;
  std::vector<CObservationBeaconRanges::Ptr> ranges;
};

class PyfgPlugin : public ::testing::Test {
 protected:
  void SetUp() override {
    roles::loadPlugin(test::buildDir() + "/lib/vir-slam/plugins/libvir_plugin_pyfg.so");
    test::writeText(folder / "g.pyfg", test::twoRobots(100));
  }
  mrpt::hwdrivers::CGenericSensor::Ptr sensor(const std::string& more, const char* name) {
    const auto s = roles::createSensor(name);
    const std::string ini =
        "[graph]\ndriver=PyfgDataset\nprocess_rate=50\nsource=" + (folder / "g.pyfg").string() +
        "\n" + more + "\n";
    s->loadConfig(mrpt::config::CConfigFileMemory(ini), "graph");
    return s;
  }
  test::TempFolder folder;
};

Content runToEnd(mrpt::hwdrivers::CGenericSensor& sensor) {
  Content c;
  auto& source = dynamic_cast<roles::RecordedSource&>(sensor);
  sensor.initialize();
  for (int calls = 0; !source.finished() && calls < 1000; ++calls) {
    sensor.doProcess();
    for (const auto& [t, object] : sensor.getObservations()) {
      if (auto o = std::dynamic_pointer_cast<CObservationRobotPose>(object)) c.poses.push_back(o);
      if (auto o = std::dynamic_pointer_cast<CObservationBeaconRanges>(object)) {
        c.ranges.push_back(o);
      }
    }
  }
  EXPECT_DOUBLE_EQ(source.progress(), 1);
  return c;
}

TEST_F(PyfgPlugin, ObservationsCarryEverything) {
  const auto s = sensor("robot=B", "pyfg");
  const Content c = runToEnd(*s);
  ASSERT_EQ(c.poses.size(), 200u);
  ASSERT_EQ(c.ranges.size(), 200u);

  const CObservationRobotPose& truth = *c.poses[2];
  EXPECT_EQ(truth.sensorLabel, "GT");
  EXPECT_EQ(rawlog::fromMrptTime(truth.timestamp), 101'000'000'000);
  EXPECT_DOUBLE_EQ(truth.pose.mean.x(), 1);
  EXPECT_DOUBLE_EQ(truth.pose.mean.y(), 2);
  EXPECT_DOUBLE_EQ(truth.pose.cov(0, 0), 0);

  const CObservationRobotPose& odometry = *c.poses[3];
  EXPECT_EQ(odometry.sensorLabel, "ODOM");
  EXPECT_DOUBLE_EQ(odometry.pose.mean.x(), 1);
  EXPECT_DOUBLE_EQ(odometry.pose.mean.y(), 0);
  EXPECT_DOUBLE_EQ(odometry.pose.cov(0, 0), 0.04);
  EXPECT_DOUBLE_EQ(odometry.pose.cov(1, 1), 0.09);
  EXPECT_DOUBLE_EQ(odometry.pose.cov(5, 5), 0.01);

  const CObservationBeaconRanges& anchor = *c.ranges[0];
  EXPECT_EQ(anchor.sensorLabel, "UWB0");
  EXPECT_EQ(rawlog::fromMrptTime(anchor.timestamp), 100'250'000'000);
  EXPECT_FLOAT_EQ(anchor.stdError, 0.05f);
  ASSERT_EQ(anchor.sensedData.size(), 1u);
  EXPECT_EQ(anchor.sensedData[0].beaconID, 7);
  EXPECT_FLOAT_EQ(anchor.sensedData[0].sensedDistance, 3);
  EXPECT_EQ(anchor.sensedData[0].sensorLocationOnRobot.norm(), 0);

  const CObservationBeaconRanges& peer = *c.ranges[1];
  EXPECT_EQ(peer.sensorLabel, "PEER");
  EXPECT_EQ(peer.sensedData.at(0).beaconID, 0);
}

TEST_F(PyfgPlugin, SaysWhereTheAnchorsAreOutsideTheObservations) {
  const auto s = sensor("robot=A", "PyfgDataset");
  s->initialize();
  const auto anchors = dynamic_cast<roles::RecordedSource&>(*s).trueAnchors();
  ASSERT_EQ(anchors.size(), 1u);
  EXPECT_EQ(anchors[0].id, 7u);
  EXPECT_DOUBLE_EQ(anchors[0].p_W.y(), -1.5);
}

TEST_F(PyfgPlugin, CanBeStartedAgain) {
  const auto s = sensor("robot=A", "pyfg");
  EXPECT_EQ(runToEnd(*s).poses.size(), 200u);
  EXPECT_EQ(runToEnd(*s).poses.size(), 200u);
}

TEST_F(PyfgPlugin, ReadsItsSectionStrictly) {
  for (const char* wrong : {"robt=A", "read_gt=maybe", "planar_sigma_z_m=-1"}) {
    EXPECT_THROW(sensor(wrong, "pyfg"), std::exception) << wrong;
  }
  EXPECT_THROW(sensor("", "pyfg")->initialize(), std::exception) << "two robots, none named";
  EXPECT_THROW(sensor("robot=A", "pyfg")->doProcess(), std::exception) << "not initialised";
}

}  // namespace
}  // namespace vir
