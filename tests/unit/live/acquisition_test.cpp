/// Sensors in threads: what fails is started again and the rest goes on.
#include "vir/live/acquisition.h"

#include <gtest/gtest.h>
#include <mrpt/hwdrivers/CGenericSensor.h>
#include <mrpt/obs/CObservationComment.h>
#include <mrpt/obs/CObservationImage.h>

#include <atomic>
#include <map>
#include <mutex>
#include <thread>

#include "vir/rawlog/stereo_images.h"
#include "vir/roles/grabber_settings.h"
#include "vir_test_rawlog.h"

namespace vir::test {

/// A wall clock that can be set.
std::atomic<TimeNs> g_set_by{0};
TimeNs wallNow() { return systemClocks().wall() + g_set_by; }

/// Says "IMU0" at every call; fails as its settings tell.
class MoodySensor : public mrpt::hwdrivers::CGenericSensor {
  DEFINE_GENERIC_SENSOR(MoodySensor)
 public:
  void initialize() override {
    if (missing_) throw std::runtime_error("no such device");
    m_state = ssWorking;
  }
  void doProcess() override {
    ++calls_;
    if (fail_at_ > 0 && calls_ == fail_at_) throw std::runtime_error("the cable is out");
    const TimeNs t = (wall_ ? wallNow() : hostNow()) + fromSeconds(ahead_s_);
    if (!camera_) return appendObservation(imuAt(t));
    const auto image = imageAt(t);
    image->image.resize(static_cast<std::size_t>(width_), 12, mrpt::img::CH_GRAY);
    if (pair_) return appendObservation(rawlog::pairOf(*image, *image));
    appendObservation(image);
  }

 protected:
  void loadConfig_sensorSpecific(const mrpt::config::CConfigFileBase& config,
                                 const std::string& section) override {
    roles::readGrabberSection(config, section, [this](OptionVisitor& v) {
      v.section("moody", "");
      v.value("fail_at", fail_at_, {0, 1000000}, "");
      v.value("missing", missing_, "");
      v.value("wall", wall_, "");
      v.value("camera", camera_, "");
      v.value("pair", pair_, "");
      v.value("width", width_, {1, 100}, "");
      v.value("ahead_s", ahead_s_, {-1e6, 1e6}, "");
    });
  }

 private:
  int fail_at_ = 0, calls_ = 0, width_ = 16;
  bool missing_ = false, camera_ = false, wall_ = false, pair_ = false;
  double ahead_s_ = 0;
};
IMPLEMENTS_GENERIC_SENSOR(MoodySensor, vir::test)

namespace {

Settings settings(const std::string& text) {
  static const bool registered = [] {
    mrpt::hwdrivers::CGenericSensor::registerClass(SENSOR_CLASS_ID(MoodySensor));
    return true;
  }();
  EXPECT_TRUE(registered);
  return Settings::fromText(text, "test.ini");
}

const std::string kGood = "[good]\ndriver = MoodySensor\nprocess_rate = 200\n";

struct Collected {
  std::map<std::size_t, std::vector<live::Arrival>> by_sensor;
  std::vector<std::string> log;
  std::vector<live::SensorStatus> status;
};

Collected collectFor(const std::string& ini, double seconds) {
  Collected out;
  std::mutex mutex;
  live::AcquisitionOptions options;
  options.first_retry_s = 0.05;
  live::Acquisition acquisition(settings(ini), "", options, [&](LogLevel, const std::string& line) {
    const std::lock_guard<std::mutex> lock(mutex);
    out.log.push_back(line);
  });
  acquisition.start();
  const TimeNs end = hostNow() + fromSeconds(seconds);
  const auto keep = [&](const std::vector<live::Arrival>& arrivals) {
    for (const live::Arrival& a : arrivals) out.by_sensor[a.sensor].push_back(a);
  };
  while (hostNow() < end) keep(acquisition.take(10 * kMs));
  acquisition.stop();
  keep(acquisition.take(0));
  out.status = acquisition.sensors();
  return out;
}

TEST(Acquisition, ASensorThatFailsIsStartedAgainWhileTheOthersGoOn) {
  const Collected got =
      collectFor(kGood + "[bad]\ndriver = MoodySensor\nprocess_rate = 200\nfail_at = 10\n", 1.0);
  EXPECT_EQ(got.status[0].restarts, 0);
  EXPECT_GE(got.status[1].restarts, 2);
  EXPECT_EQ(got.status[1].problem, "the cable is out");
  // All it said before each failure is there.
  EXPECT_EQ(static_cast<long>(got.by_sensor.at(1).size()), got.status[1].observations);
  EXPECT_GE(got.by_sensor.at(1).size(), 18u);
  EXPECT_GE(got.by_sensor.at(0).size(), 50u);
  EXPECT_EQ(static_cast<long>(got.by_sensor.at(0).size()), got.status[0].observations);
  ASSERT_FALSE(got.log.empty());
  EXPECT_NE(got.log[0].find("bad: the cable is out"), std::string::npos) << got.log[0];
}

/// Set back by an hour, 1957 of 2784 readings were once stamped 100 ns apart.
TEST(Acquisition, AClockThatIsSetChangesNoStamp) {
  useHostClocks({wallNow, systemClocks().monotonic, systemClocks().awake});
  for (const double set_s : {-3600.0, -0.4, 5.0, 1e7}) {
    pinHostClock();
    std::thread ntp([set_s] {
      std::this_thread::sleep_for(std::chrono::milliseconds(300));
      g_set_by = fromSeconds(set_s);
    });
    const Collected got =
        collectFor(kGood + "[wall]\ndriver = MoodySensor\nprocess_rate = 200\nwall = true\n", 0.6);
    ntp.join();
    int notes = 0;
    for (const auto& [sensor, arrivals] : got.by_sensor) {
      TimeNs last = 0;
      for (const live::Arrival& a : arrivals) {
        const TimeNs t = rawlog::fromMrptTime(a.observation->timestamp);
        notes += dynamic_cast<const mrpt::obs::CObservationComment*>(a.observation.get()) ? 1 : 0;
        EXPECT_LT(std::abs(t - a.arrival), 100 * kMs) << sensor << " after " << set_s;
        EXPECT_LT(t - last, last == 0 ? INT64_MAX : 200 * kMs) << sensor << " after " << set_s;
        last = t;
      }
      EXPECT_GT(arrivals.size(), 30u);
    }
    EXPECT_EQ(notes, 1) << set_s;
    ASSERT_EQ(got.log.size(), 1u) << set_s;
    EXPECT_NE(got.log[0].find("the host's clock was set by"), std::string::npos) << got.log[0];
    g_set_by = 0;
  }
  useHostClocks(systemClocks());
}

TEST(Acquisition, WhoHearsTheLogMayAskForTheState) {
  live::Acquisition* asked = nullptr;
  std::atomic<int> heard{0};
  live::AcquisitionOptions options;
  options.first_retry_s = 0.05;
  const Settings ini =
      settings(kGood + "[bad]\ndriver = MoodySensor\nprocess_rate = 200\nfail_at = 10\n");
  live::Acquisition acquisition(ini, "", options, [&](LogLevel, const std::string& text) {
    if (text.find("works again") == std::string::npos) return;
    heard += static_cast<int>(asked->sensors().size());
  });
  asked = &acquisition;
  acquisition.start();
  const TimeNs end = hostNow() + fromSeconds(20);
  while (heard == 0 && hostNow() < end) acquisition.take(10 * kMs);
  acquisition.stop();
  EXPECT_GE(heard, 2) << "nobody said that it works again";
}

TEST(Acquisition, AMissingSensorEndsItAllUnlessItIsOptional) {
  const std::string bad = "[bad]\ndriver = MoodySensor\nprocess_rate = 100\nmissing = true\n";
  live::Acquisition acquisition(settings(kGood + bad), "", {}, {});
  try {
    acquisition.start();
    FAIL() << "started without the sensor";
  } catch (const std::runtime_error& e) {
    EXPECT_NE(std::string(e.what()).find("bad: no such device"), std::string::npos) << e.what();
  }
  EXPECT_TRUE(acquisition.take(0).empty());
  const Collected got = collectFor(kGood + bad + "optional = true\n", 0.3);
  EXPECT_EQ(got.status[1].state, live::SensorState::missing);
  EXPECT_GE(got.by_sensor.at(0).size(), 15u);
}

TEST(Acquisition, AClockOfItsOwnIsPutOnTheHosts) {
  const Collected got =
      collectFor(kGood + "[ahead]\ndriver = MoodySensor\nprocess_rate = 100\nahead_s = 3600\n" +
                     "[kept]\ndriver = MoodySensor\nprocess_rate = 100\nahead_s = 3600\n"
                     "clock = keep\n",
                 0.5);
  EXPECT_FALSE(got.status[0].clock_mapped);
  EXPECT_TRUE(got.status[1].clock_mapped);
  EXPECT_FALSE(got.status[2].clock_mapped);
  TimeNs last = 0;
  for (const live::Arrival& a : got.by_sensor.at(1)) {
    const TimeNs t = rawlog::fromMrptTime(a.observation->timestamp);
    EXPECT_GT(t, last);
    EXPECT_NEAR(toSeconds(t - a.arrival), 0, 0.2);
    last = t;
  }
  const live::Arrival& kept = got.by_sensor.at(2).front();
  EXPECT_NEAR(toSeconds(rawlog::fromMrptTime(kept.observation->timestamp) - kept.arrival), 3600,
              0.2);
}

TEST(Acquisition, ACameraIsCompletedFromTheIni) {
  const Collected got = collectFor(
      "[cam]\ndriver = MoodySensor\nprocess_rate = 50\ncamera = true\n"
      "intrinsics = 100 101 8 6\ndistortion = radtan\ndist = 0.1 0.2 0.3 0.4\n"
      "camera_pose = 1 2 3 90 0 0\nstamp_offset_s = -0.4\n",
      0.3);
  const auto image = std::dynamic_pointer_cast<mrpt::obs::CObservationImage>(
      got.by_sensor.at(0).front().observation);
  ASSERT_TRUE(image);
  EXPECT_EQ(image->cameraParams.fx(), 100);
  EXPECT_EQ(image->cameraParams.fy(), 101);
  EXPECT_EQ(image->cameraParams.cx(), 8);
  EXPECT_EQ(image->cameraParams.ncols, 16u);
  EXPECT_EQ(image->cameraParams.k2(), 0.2);
  EXPECT_NEAR(image->cameraPose.y(), 2, 1e-12);
  EXPECT_NEAR(image->cameraPose.yaw(), M_PI / 2, 1e-12);
  const live::Arrival& a = got.by_sensor.at(0).front();
  EXPECT_NEAR(toSeconds(rawlog::fromMrptTime(image->timestamp) - a.arrival), -0.4, 0.1);
}

TEST(Acquisition, TheViewsOfTwoCamerasInOneImageBecomeTheirImages) {
  const Collected got = collectFor(
      "[cam]\ndriver = MoodySensor\nprocess_rate = 50\ncamera = true\nside_by_side = true\n"
      "intrinsics = 100 101 4 6\ncamera_pose = 1 2 3 90 0 0\nclock = device\n"
      "right_camera_pose = 1.1 2 3 90 0 0\nright_intrinsics = 102 103 4 6\n",
      0.3);
  const auto& all = got.by_sensor.at(0);
  ASSERT_GE(all.size(), 4u);
  for (std::size_t k = 0; k < 4; ++k) {
    const auto image = std::dynamic_pointer_cast<mrpt::obs::CObservationImage>(all[k].observation);
    ASSERT_TRUE(image);
    const bool right = k % 2 == 1;
    EXPECT_EQ(image->sensorLabel, right ? "CAM1" : "CAM0");
    EXPECT_EQ(image->image.getWidth(), 8u);
    EXPECT_EQ(image->cameraParams.ncols, 8u);
    EXPECT_EQ(image->cameraParams.fx(), right ? 102 : 100);
    EXPECT_NEAR(image->cameraPose.x(), right ? 1.1 : 1, 1e-12);
    if (right) {
      EXPECT_EQ(image->timestamp, all[k - 1].observation->timestamp);
    }
  }
}

TEST(Acquisition, APairOfADriverBecomesTwoImagesAndAnOddOneStaysWholeAndIsSaid) {
  const Collected pair = collectFor(
      "[cam]\ndriver = MoodySensor\nprocess_rate = 50\ncamera = true\npair = true\n"
      "right_camera_pose = 1.1 2 3 90 0 0\n",
      0.3);
  ASSERT_GE(pair.by_sensor.at(0).size(), 2u);
  const auto right =
      std::dynamic_pointer_cast<mrpt::obs::CObservationImage>(pair.by_sensor.at(0)[1].observation);
  ASSERT_TRUE(right);
  EXPECT_EQ(right->sensorLabel, "CAM1");
  EXPECT_NEAR(right->cameraPose.x(), 1.1, 1e-12);

  const Collected odd = collectFor(
      "[cam]\ndriver = MoodySensor\nprocess_rate = 50\ncamera = true\nwidth = 15\n"
      "side_by_side = true\n",
      0.3);
  ASSERT_GE(odd.by_sensor.at(0).size(), 2u);
  EXPECT_EQ(odd.by_sensor.at(0).front().observation->sensorLabel, "CAM0");
  ASSERT_EQ(odd.log.size(), 1u);
  EXPECT_NE(odd.log[0].find("an image of 15x12 pixels holds no two views"), std::string::npos)
      << odd.log[0];
}

TEST(Acquisition, WrongSettingsAreRefusedBeforeAnythingStarts) {
  const auto refused = [](const std::string& ini, const std::string& why) {
    try {
      live::Acquisition acquisition(settings(ini), "", {}, {});
      FAIL() << ini;
    } catch (const std::exception& e) {
      EXPECT_NE(std::string(e.what()).find(why), std::string::npos) << e.what();
    }
  };
  refused("[a]\nx = 1\n", "no sensor");
  refused("[a]\ndriver = NoSuchSensor\nprocess_rate = 1\n", "NoSuchSensor");
  refused("[a]\ndriver = MoodySensor\n", "process_rate");
  refused("[a]\ndriver = MoodySensor\nprocess_rate = 10\nfail = 1\n", "fail");
  refused("[a]\ndriver = MoodySensor\nprocess_rate = 10\nclock = mine\n", "clock");
  refused("[a]\ndriver = MoodySensor\nprocess_rate = 10\nintrinsics = 1 2\n", "4 numbers");
  for (const char* wrong : {"0 100 4 6", "100 -1 4 6", "nan 100 4 6"}) {
    refused(
        "[a]\ndriver = MoodySensor\nprocess_rate = 10\nside_by_side = true\nright_intrinsics = " +
            std::string(wrong) + "\n",
        "right_intrinsics");
  }
}

}  // namespace
}  // namespace vir::test
