/// The sensor as it is used: loaded as a plugin, asked for observations.
#include <gtest/gtest.h>
#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/obs/CObservationBeaconRanges.h>
#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CObservationRobotPose.h>

#include "vir/core/settings.h"
#include "vir/rawlog/mrpt_time.h"
#include "vir/roles/plugin_loader.h"
#include "vir/roles/recorded_source.h"
#include "vir/roles/sensor_registry.h"
#include "vir_test_data.h"
#include "vir_test_euroc_folder.h"
#include "vir_test_paths.h"

namespace vir {
namespace {

using namespace mrpt::obs;

struct Content {
  std::vector<CObservationImage::Ptr> images;
  std::vector<CObservationIMU::Ptr> imu;
  std::vector<CObservationBeaconRanges::Ptr> ranges;
  std::vector<CObservationRobotPose::Ptr> truth;
  std::map<std::string, long> counters;
  std::string companion;
  bool in_order = true;
};

mrpt::hwdrivers::CGenericSensor::Ptr makeSensor(const std::string& name) {
  roles::loadPlugin(test::buildDir() + "/lib/vir-slam/plugins/libvir_plugin_euroc.so");
  return roles::createSensor(name);
}

void collect(const CObservation::Ptr& obs, Content* c) {
  if (auto o = std::dynamic_pointer_cast<CObservationImage>(obs)) c->images.push_back(o);
  if (auto o = std::dynamic_pointer_cast<CObservationIMU>(obs)) c->imu.push_back(o);
  if (auto o = std::dynamic_pointer_cast<CObservationBeaconRanges>(obs)) c->ranges.push_back(o);
  if (auto o = std::dynamic_pointer_cast<CObservationRobotPose>(obs)) c->truth.push_back(o);
}

Content runToEnd(mrpt::hwdrivers::CGenericSensor& sensor) {
  Content c;
  auto& source = dynamic_cast<roles::RecordedSource&>(sensor);
  sensor.initialize();
  c.companion = source.companionIni();
  mrpt::Clock::time_point last;
  while (!source.finished()) {
    sensor.doProcess();
    for (const auto& [t, object] : sensor.getObservations()) {
      c.in_order = c.in_order && t >= last;
      last = t;
      collect(std::dynamic_pointer_cast<CObservation>(object), &c);
    }
  }
  EXPECT_DOUBLE_EQ(source.progress(), 1.0);
  for (const auto& [name, n] : source.counters()) c.counters[name] = n;
  return c;
}

Content import(const std::string& folder, const std::vector<std::string>& set = {}) {
  const auto sensor = makeSensor("euroc");
  Settings settings;
  for (const auto& s : set) settings.set(s);
  settings.set("euroc.source=" + folder);
  SettingsReader reader(settings);
  dynamic_cast<roles::RecordedSource&>(*sensor).describe(reader);
  reader.finish();
  return runToEnd(*sensor);
}

TEST(EurocPlugin, ObservationsCarryEverything) {
  const test::EurocFolder f;
  const Content c = import(f.root().string(), {"euroc.images=embed"});
  ASSERT_EQ(c.images.size(), 10u);
  ASSERT_EQ(c.imu.size(), static_cast<std::size_t>(f.imuRows()));
  ASSERT_EQ(c.ranges.size(), 10u);
  ASSERT_EQ(c.truth.size(), static_cast<std::size_t>(f.imuRows()));
  EXPECT_TRUE(c.in_order);

  const CObservationImage& im = *c.images[4];
  EXPECT_EQ(im.sensorLabel, "CAM0");
  EXPECT_EQ(rawlog::fromMrptTime(im.timestamp), f.imageStamp(4) / 100 * 100);
  EXPECT_EQ(im.image.at<uint8_t>(20, 7), 10 + 4 + 20);
  EXPECT_EQ(im.cameraParams.ncols, 64u);
  EXPECT_DOUBLE_EQ(im.cameraParams.fx(), 40.5);
  EXPECT_DOUBLE_EQ(im.cameraParams.cy(), 24.75);
  EXPECT_EQ(im.cameraParams.distortion, mrpt::img::DistortionModel::plumb_bob);
  EXPECT_DOUBLE_EQ(im.cameraParams.p2(), 1.5e-05);
  EXPECT_NEAR(im.cameraPose.x(), 0.1, 1e-9);
  const mrpt::math::TPoint3D ahead = im.cameraPose.composePoint({0, 0, 1});
  EXPECT_NEAR(ahead.x, 1.1, 1e-9);  // looks along body x

  const CObservationIMU& imu = *c.imu[7];
  EXPECT_EQ(imu.sensorLabel, "IMU0");
  EXPECT_DOUBLE_EQ(imu.get(IMU_WX), 0.007);
  EXPECT_DOUBLE_EQ(imu.get(IMU_WY), 0.02);
  EXPECT_DOUBLE_EQ(imu.get(IMU_WZ), 0.03);
  EXPECT_DOUBLE_EQ(imu.get(IMU_X_ACC), 0.1);
  EXPECT_DOUBLE_EQ(imu.get(IMU_Z_ACC), 9.81);

  const CObservationBeaconRanges& range = *c.ranges[2];
  EXPECT_EQ(range.sensorLabel, "UWB0");
  EXPECT_FLOAT_EQ(range.stdError, 0.07f);
  ASSERT_EQ(range.sensedData.size(), 1u);
  EXPECT_EQ(range.sensedData[0].beaconID, 3);
  EXPECT_FLOAT_EQ(range.sensedData[0].sensedDistance, 2.52f);
  EXPECT_NEAR(range.sensedData[0].sensorLocationOnRobot.y(), 0.2, 1e-9);

  EXPECT_EQ(c.truth[0]->sensorLabel, "GT");
  EXPECT_NEAR(c.truth[20]->pose.mean.yaw(), 0.05, 1e-8);
  EXPECT_NEAR(c.truth[20]->pose.mean.x(), 0.1, 1e-9);
  EXPECT_NE(c.companion.find("[Imu]\ngyro_noise_density = 0.00017"), std::string::npos)
      << c.companion;
}

TEST(EurocPlugin, TheEquidistantLensIsKannalaBrandt) {
  test::EurocFolderOptions o;
  o.tum_vi = true;
  const test::EurocFolder f(o);
  const Content c = import(f.root().string(), {"euroc.images=embed"});
  ASSERT_EQ(c.images.size(), 10u);
  const auto& camera = c.images[0]->cameraParams;
  EXPECT_EQ(camera.distortion, mrpt::img::DistortionModel::kannala_brandt);
  EXPECT_DOUBLE_EQ(camera.k1(), -0.28);
  EXPECT_DOUBLE_EQ(camera.k2(), 0.07);
  EXPECT_DOUBLE_EQ(camera.k3(), 0.0002);
  EXPECT_DOUBLE_EQ(camera.k4(), 1.5e-05);
  EXPECT_EQ(c.images[0]->image.at<uint8_t>(20, 7), 10 + 20);
  EXPECT_EQ(c.counters.at("images_converted_16_to_8_bit"), 10);
  EXPECT_EQ(c.truth.size(), static_cast<std::size_t>(f.imuRows()));
}

TEST(EurocPlugin, BadImagesAreLeftOutAndCounted) {
  const test::EurocFolder f;
  std::filesystem::remove(f.imageFile(2));
  test::writeText(f.imageFile(5), "garbage");
  const Content c = import(f.root().string(), {"euroc.images=embed"});
  EXPECT_EQ(c.images.size(), 8u);
  EXPECT_EQ(c.counters.at("images"), 8);
  EXPECT_EQ(c.counters.at("image_missing"), 1);
  EXPECT_EQ(c.counters.at("image_undecodable"), 1);
}

TEST(EurocPlugin, NotOneUsableImageIsAnError) {
  const test::EurocFolder f;
  std::filesystem::remove_all(f.mav0() / "cam0/data");
  EXPECT_THROW(import(f.root().string(), {"euroc.images=embed"}), std::runtime_error);
}

TEST(EurocPlugin, ReadsASectionOfRawlogGrabberStrictly) {
  const test::EurocFolder f;
  const std::string common =
      "[cam]\ndriver=EurocDataset\nprocess_rate=50\nsensorLabel=x\nimages=embed\n"
      "source=" +
      f.root().string() + "  // a comment\n";
  const auto sensor = makeSensor("EurocDataset");
  sensor->loadConfig(mrpt::config::CConfigFileMemory(common + "max_duration_s=0.2\n"), "cam");
  EXPECT_EQ(runToEnd(*sensor).images.size(), 5u);
  for (const char* wrong : {"max_duration_s=long", "max_duration_s=-1", "imges=link", "images=move",
                            "read_gt=maybe", "lever_arm_m=1 2"}) {
    EXPECT_THROW(makeSensor("euroc")->loadConfig(
                     mrpt::config::CConfigFileMemory(common + wrong + "\n"), "cam"),
                 std::exception)
        << wrong;
  }
}

TEST(EurocPlugin, TheSharedMachineHallClip) {
  VIR_REQUIRE_DATA(folder, "euroc_MH01_clip30s");
  const Content c = import(folder.string(), {"euroc.images=embed", "euroc.max_duration_s=1",
                                             "euroc.other_cameras=false"});
  ASSERT_EQ(c.images.size(), 21u);
  EXPECT_EQ(rawlog::fromMrptTime(c.images[0]->timestamp),
            1403636584763555500);  // ...584 ns to 100 ns
  EXPECT_EQ(rawlog::fromMrptTime(c.imu[0]->timestamp), 1403636579758555300);
  EXPECT_EQ(rawlog::fromMrptTime(c.truth[0]->timestamp), 1403636580838560000);
  EXPECT_NEAR(c.truth[0]->pose.mean.x(), 4.688319, 1e-9);
  EXPECT_TRUE(c.in_order);
}

TEST(EurocPlugin, TheSharedClipsAreImportedWhole) {
  VIR_REQUIRE_DATA(clip, "euroc_MH01_clip30s");
  const Content a = import(clip.string(), {"euroc.camera=none"});
  EXPECT_EQ(a.imu.size(), 7192u);
  EXPECT_EQ(a.truth.size(), 6975u);
  VIR_REQUIRE_DATA(rendered, "rendered_V102_32s");
  const Content b = import(rendered.string(), {"euroc.camera=none"});
  EXPECT_EQ(b.imu.size(), 6410u);
  EXPECT_EQ(b.truth.size(), 6410u);
  EXPECT_EQ(b.ranges.size(), 641u);
  EXPECT_FLOAT_EQ(b.ranges[0]->stdError, 0.05f);
}

}  // namespace
}  // namespace vir
