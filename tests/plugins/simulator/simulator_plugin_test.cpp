/// The sensor as it is used: loaded as a plugin, asked for observations.
#include <gtest/gtest.h>
#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/obs/CObservationBeaconRanges.h>
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/obs/CObservationStereoImagesFeatures.h>

#include <fstream>
#include <map>

#include "vir/core/settings.h"
#include "vir/rawlog/mrpt_time.h"
#include "vir/roles/plugin_loader.h"
#include "vir/roles/recorded_source.h"
#include "vir/roles/sensor_registry.h"
#include "vir_test_paths.h"
#include "vir_test_temp_folder.h"

namespace vir {
namespace {

using namespace mrpt::obs;

const std::vector<std::string> kSmall{"simulator.robots=A B",
                                      "Robot_A.duration_s=6",
                                      "Robot_B.duration_s=6",
                                      "Camera.width_px=96",
                                      "Camera.height_px=64",
                                      "Camera.fx_px=60",
                                      "Camera.fy_px=60",
                                      "Camera.cx_px=48",
                                      "Camera.cy_px=32",
                                      "SimulatedRanges.anchor_m=2 2 1",
                                      "SimulatedRanges.anchor_id=5",
                                      "Robot_B.start_m=1 2 0",
                                      "SimulatedRanges.lever_arm_m=0.1 0 0.2",
                                      "SimulatedTeam.anchor_known_s=2"};

class SimulatorPlugin : public ::testing::Test {
 protected:
  void SetUp() override {
    roles::loadPlugin(test::buildDir() + "/lib/vir-slam/plugins/libvir_plugin_simulator.so");
  }

  mrpt::hwdrivers::CGenericSensor::Ptr sensor(const std::vector<std::string>& more = {}) {
    const auto s = roles::createSensor("simulator");
    Settings settings;
    for (const std::string& a : kSmall) settings.set(a);
    for (const std::string& a : more) settings.set(a);
    SettingsReader reader(settings);
    dynamic_cast<roles::RecordedSource&>(*s).describe(reader);
    reader.finish();
    return s;
  }

  /// By label, in the order given out.
  std::map<std::string, std::vector<CObservation::Ptr>> runToEnd(
      mrpt::hwdrivers::CGenericSensor& sensor) {
    std::map<std::string, std::vector<CObservation::Ptr>> out;
    auto& source = dynamic_cast<roles::RecordedSource&>(sensor);
    sensor.initialize();
    TimeNs last = 0;
    while (!source.finished()) {
      sensor.doProcess();
      for (const auto& [t, object] : sensor.getObservations()) {
        const auto obs = std::dynamic_pointer_cast<CObservation>(object);
        EXPECT_GE(rawlog::fromMrptTime(obs->timestamp), last);
        last = rawlog::fromMrptTime(obs->timestamp);
        out[obs->sensorLabel].push_back(obs);
      }
    }
    EXPECT_DOUBLE_EQ(source.progress(), 1);
    return out;
  }

  test::TempFolder folder;
};

TEST_F(SimulatorPlugin, GivesEverySensorUnderItsLabel) {
  const auto s = sensor({"simulator.images=embed"});
  const auto got = runToEnd(*s);
  for (const char* label : {"IMU0", "CAM0", "UWB0", "PEER", "PEER:1", "PEER:1:ANCHOR:5", "GT"}) {
    EXPECT_EQ(got.count(label), 1u) << label;
  }
  EXPECT_EQ(got.size(), 7u);
  const auto image = std::dynamic_pointer_cast<CObservationImage>(got.at("CAM0")[3]);
  ASSERT_TRUE(image);
  EXPECT_EQ(image->image.getWidth(), 96u);
  EXPECT_DOUBLE_EQ(image->cameraParams.fx(), 60);
  EXPECT_EQ(image->cameraParams.distortion, mrpt::img::DistortionModel::plumb_bob);
  EXPECT_DOUBLE_EQ(image->cameraPose.x(), 0.05);
  const auto range = std::dynamic_pointer_cast<CObservationBeaconRanges>(got.at("UWB0")[0]);
  ASSERT_EQ(range->sensedData.size(), 1u);
  EXPECT_EQ(range->sensedData[0].beaconID, 5);
  EXPECT_NEAR(range->sensedData[0].sensorLocationOnRobot.z(), 0.2, 1e-9);
  EXPECT_NEAR(range->stdError, 0.05, 1e-6);
  const auto& source = dynamic_cast<roles::RecordedSource&>(*s);
  ASSERT_EQ(source.trueAnchors().size(), 1u);
  EXPECT_EQ(source.trueAnchors()[0].id, 5u);
  EXPECT_NE(source.companionIni().find("acc_noise_density = 0.002"), std::string::npos);
}

TEST_F(SimulatorPlugin, WhatThePeerTellsComesWithTheRange) {
  const auto got = runToEnd(*sensor({"simulator.images=none"}));
  const auto& ranges = got.at("PEER");
  const auto& told = got.at("PEER:1");
  ASSERT_EQ(ranges.size(), told.size());
  for (std::size_t k = 0; k < ranges.size(); ++k) {
    EXPECT_EQ(ranges[k]->timestamp, told[k]->timestamp);
    const auto range = std::dynamic_pointer_cast<CObservationBeaconRanges>(ranges[k]);
    EXPECT_EQ(range->sensedData.at(0).beaconID, 1);
    const auto pose = std::dynamic_pointer_cast<CObservationRobotPose>(told[k]);
    EXPECT_GT(pose->pose.cov(0, 0), 0);
    EXPECT_DOUBLE_EQ(pose->pose.cov(3, 3), 0);
    EXPECT_DOUBLE_EQ(pose->pose.mean.yaw(), 0);
  }
  const auto& anchors = got.at("PEER:1:ANCHOR:5");
  EXPECT_LT(anchors.size(), told.size());
  EXPECT_GE(toSeconds(rawlog::fromMrptTime(anchors[0]->timestamp) -
                      rawlog::fromMrptTime(ranges[0]->timestamp)),
            1.5);
}

TEST_F(SimulatorPlugin, TracksInsteadOfImages) {
  const auto got = runToEnd(*sensor({"simulator.tracks=true"}));
  EXPECT_EQ(got.count("CAM0"), 0u);
  ASSERT_GT(got.at("TRACKS0").size(), 100u);
  const auto tracks =
      std::dynamic_pointer_cast<CObservationStereoImagesFeatures>(got.at("TRACKS0")[50]);
  ASSERT_TRUE(tracks);
  EXPECT_GT(tracks->theFeatures.size(), 3u);
  EXPECT_DOUBLE_EQ(tracks->cameraLeft.fx(), 60);
  EXPECT_DOUBLE_EQ(tracks->cameraPoseOnRobot.x(), 0.05);
  for (const auto& f : tracks->theFeatures) {
    EXPECT_GT(f.ID, 0u);
    EXPECT_GT(f.pixels.first.x, 0);
    EXPECT_LT(f.pixels.first.x, 96);
  }
}

TEST_F(SimulatorPlugin, ImagesGoToTheFolderGiven) {
  const auto s = sensor({"simulator.image_format=png"});
  s->setPathForExternalImages((folder / "x_Images").string());
  const auto got = runToEnd(*s);
  const auto image = std::dynamic_pointer_cast<CObservationImage>(got.at("CAM0")[0]);
  ASSERT_TRUE(image->image.isExternallyStored());
  EXPECT_EQ(image->image.getExternalStorageFile(), "CAM0_1600000000002300000.png");
  EXPECT_TRUE(std::filesystem::exists(folder / "x_Images" / image->image.getExternalStorageFile()));
}

TEST_F(SimulatorPlugin, IsConfiguredAsAnyGrabberSensor) {
  {
    std::ofstream ini((folder / "world.ini").string());
    ini << "[simulator]\nrobots = A B\nimages = none\n[Robot_B]\nduration_s = 5\n";
  }
  const auto s = roles::createSensor("SimulatorSensor");
  const std::string keys =
      "[any]\ndriver=SimulatorSensor\nprocess_rate=50\nini=" + (folder / "world.ini").string() +
      "\nrobot=B\n";
  s->loadConfig(mrpt::config::CConfigFileMemory(keys), "any");
  const auto got = runToEnd(*s);
  EXPECT_EQ(got.count("PEER:0"), 1u);
  EXPECT_NEAR(static_cast<double>(got.at("IMU0").size()), 1000, 2);
}

TEST_F(SimulatorPlugin, CanBeRunTwice) {
  const auto s = sensor({"simulator.images=none"});
  const auto first = runToEnd(*s), second = runToEnd(*s);
  EXPECT_EQ(first.at("IMU0").size(), second.at("IMU0").size());
}

}  // namespace
}  // namespace vir
