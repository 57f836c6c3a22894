/// `vir-slam import` and `run` of bags as a user calls them.
#include <gtest/gtest.h>
#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationImage.h>

#include <opencv2/imgcodecs.hpp>

#include "vir/rawlog/convert.h"
#include "vir/rawlog/mrpt_pose.h"
#include "vir/rawlog/mrpt_time.h"
#include "vir/rawlog/rawlog_reader.h"
#include "vir_test_bag_writer.h"
#include "vir_test_data.h"
#include "vir_test_shell.h"
#include "vir_test_temp_folder.h"

namespace vir {
namespace {

namespace fs = std::filesystem;
using test::contains;
using test::Outcome;
using test::quoted;
using test::virSlam;

std::string fixture(const std::string& name) {
  return test::sourceDir() + "/tests/fixtures/bags/" + name;
}

class BagImport : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  Outcome import(const std::string& source, const std::string& more = "") {
    return virSlam("import " + quoted(source) + " --out " + quoted(path("x.rawlog")) + " " + more);
  }
  test::TempFolder folder_;
};

TEST_F(BagImport, FindsTheDriverAndTellsWhatItTook) {
  for (const char* bag : {"ros1_bz2.bag", "ros2_lz4.mcap", "ros2_foxy.db3", "ros2_split"}) {
    const Outcome o = import(fixture(bag));
    // Without descriptions of types its ranges are lost, and what is written is a part only.
    const bool part = std::string(bag) == "ros2_foxy.db3";
    EXPECT_EQ(o.code, part ? 1 : 0) << o.text;
    EXPECT_EQ(contains(o.text, "x.rawlog is a part only"), part) << o.text;
    EXPECT_TRUE(contains(o.text, "/cam0/image_raw (sensor_msgs/Image) taken as camera, CAM0"));
    EXPECT_TRUE(contains(o.text, "intrinsics from /cam0/camera_info")) << o.text;
    EXPECT_TRUE(fs::exists(path("x.rawlog")));
    EXPECT_TRUE(fs::exists(path("x_Images/CAM0_1600000000050000000.png")));
  }
}

TEST_F(BagImport, ListsTopics) {
  const Outcome o = virSlam("import " + quoted(fixture("ros2_zstd.mcap")) + " --list");
  EXPECT_EQ(o.code, 0) << o.text;
  EXPECT_TRUE(contains(o.text, "/imu0")) << o.text;
  EXPECT_TRUE(contains(o.text, "200.00")) << o.text;
  EXPECT_TRUE(contains(o.text, "32x24")) << o.text;
}

TEST_F(BagImport, SaysWhatIsWrongAndLeavesNothing) {
  Outcome o = import(fixture("make_db3.py"));
  EXPECT_EQ(o.code, 2);
  EXPECT_TRUE(contains(o.text, "no driver knows")) << o.text;
  EXPECT_TRUE(contains(o.text, "rosbag2")) << o.text;
  o = import(path("nowhere.bag"));
  EXPECT_EQ(o.code, 2);
  o = import(fixture("ros1_lz4.bag"), "--topic camera=/nowhere");
  EXPECT_EQ(o.code, 1);
  EXPECT_TRUE(contains(o.text, "/cam0/image_raw")) << o.text;
  o = virSlam("import " + quoted(fixture("ros1_lz4.bag")));
  EXPECT_EQ(o.code, 2);
  EXPECT_TRUE(contains(o.text, "--out")) << o.text;
  test::writeText(path("cut.bag"), test::readText(fixture("ros1_none.bag")).substr(0, 30'000));
  o = import(path("cut.bag"));
  EXPECT_EQ(o.code, 1) << o.text;
  EXPECT_TRUE(contains(o.text, "cut off")) << o.text;
}

/// `check` reads every kind of bag as `import` does, and says if one of them is not whole.
TEST_F(BagImport, CheckReadsBagsAndSaysIfTheyAreCutOff) {
  for (const char* name : {"ros1_none.bag", "ros1_lz4.bag", "ros2_none.mcap", "ros2_split"}) {
    const Outcome o =
        virSlam("check " + quoted(fixture(name)) + " --json " + quoted(path("c.json")));
    EXPECT_EQ(o.code, 0) << name << o.text;
    EXPECT_TRUE(contains(o.text, "fine")) << name << o.text;
    const std::string json = test::readText(path("c.json"));
    EXPECT_TRUE(contains(json, "\"verdict\": \"fine\"")) << json;
    for (const char* label : {"CAM0", "IMU0", "UWB0", "GT"}) {
      EXPECT_TRUE(contains(json, "\"label\": \"" + std::string(label) + "\"")) << name << json;
    }
  }
  for (const char* name : {"ros1_none.bag", "ros2_none.mcap", "ros2_foxy.db3"}) {
    const std::string cut = path("cut" + fs::path(name).extension().string());
    test::writeText(cut, test::readText(fixture(name)).substr(0, 30000));
    const Outcome o = virSlam("check " + quoted(cut) + " --json " + quoted(path("c.json")));
    EXPECT_EQ(o.code, 3) << name << o.text;
    EXPECT_TRUE(contains(o.text, "damaged or was cut off")) << name << o.text;
    EXPECT_TRUE(contains(test::readText(path("c.json")), "\"kind\": \"damaged\"")) << name;
  }
}

/// Its ranges have a type that this kind of bag does not describe: none of them is read.
TEST_F(BagImport, CheckSaysIfAStreamCannotBeRead) {
  const Outcome o = virSlam("check " + quoted(fixture("ros2_foxy.db3")));
  EXPECT_EQ(o.code, 3) << o.text;
  EXPECT_TRUE(contains(o.text, "lines or messages are no readings")) << o.text;
  EXPECT_TRUE(contains(o.text, "undecodable_UWB0 10")) << o.text;
}

TEST_F(BagImport, RunImportsFirst) {
  const Outcome o =
      virSlam("run " + quoted(fixture("ros2_split")) + " --out " + quoted(path("out")));
  // Too short to begin: no pose. What matters here is that it was imported and read.
  EXPECT_EQ(o.code, 1) << o.text;
  EXPECT_TRUE(fs::exists(path("out/recording.rawlog")));
  EXPECT_TRUE(contains(test::readText(path("out/summary.json")), "\"frames\": 8")) << o.text;
  const Outcome again =
      virSlam("run " + quoted(path("out/recording.rawlog")) + " --out " + quoted(path("again")));
  EXPECT_EQ(again.code, 1) << again.text;
  EXPECT_TRUE(contains(test::readText(path("again/summary.json")), "\"frames\": 8"));
}

/// What an import of the folder gave, to compare with.
struct Kept {
  std::vector<ImuSample> imu;
  std::vector<std::pair<TimeNs, cv::Mat>> images;
  mrpt::img::TCamera camera;
  Pose T_B_C;
};

Kept readRawlog(const std::string& rawlog) {
  Kept out;
  rawlog::RawlogReader reader(rawlog);
  const std::string folder = rawlog.substr(0, rawlog.size() - 7) + "_Images/";
  while (const auto o = reader.next()) {
    if (const auto imu = rawlog::imuSampleOf(*o)) {
      out.imu.push_back(*imu);
    } else if (const auto* i = dynamic_cast<const mrpt::obs::CObservationImage*>(o.get())) {
      const std::string name = fs::path(i->image.getExternalStorageFile()).filename().string();
      out.images.emplace_back(rawlog::fromMrptTime(i->timestamp),
                              cv::imread(folder + name, cv::IMREAD_UNCHANGED));
      out.camera = i->cameraParams;
      out.T_B_C = rawlog::fromMrptPose(i->cameraPose);
    }
  }
  return out;
}

std::unique_ptr<test::BagWriter> writerFor(const std::string& path) {
  if (path.find(".bag") != std::string::npos) return std::make_unique<test::Ros1Writer>(path);
  if (path.find(".db3") != std::string::npos) return std::make_unique<test::SqliteWriter>(path);
  return std::make_unique<test::McapWriter>(path);
}

/// The first two seconds of a real recording.
void writeBag(const Kept& k, const std::string& path) {
  const auto bag = writerFor(path);
  const TimeNs start = k.imu.front().t;
  const auto& c = k.camera;
  test::writeCameraInfo(*bag, "/cam0/camera_info", start, c.ncols, c.nrows, "plumb_bob",
                        {c.k1(), c.k2(), c.p1(), c.p2(), c.k3()}, c.fx(), c.fy(), c.cx(), c.cy());
  const Pose& T = k.T_B_C;
  test::writeStatic(*bag, start, {T.p.x(), T.p.y(), T.p.z()}, {T.q.x(), T.q.y(), T.q.z(), T.q.w()});
  std::size_t next = 0;
  for (const ImuSample& s : k.imu) {
    for (; next < k.images.size() && k.images[next].first <= s.t; ++next) {
      const auto& [t, m] = k.images[next];
      test::writeImage(*bag, "/cam0/image_raw", t, t + 1'000'000,
                       static_cast<std::uint32_t>(m.cols), static_cast<std::uint32_t>(m.rows),
                       "mono8", static_cast<std::uint32_t>(m.cols), {m.data, m.data + m.total()});
    }
    test::writeImu(*bag, "/imu0", s.t, s.t + 1'000'000, {s.gyro.x(), s.gyro.y(), s.gyro.z()},
                   {s.acc.x(), s.acc.y(), s.acc.z()});
  }
}

TEST_F(BagImport, ARealRecordingIsTheSameFromEveryFormat) {
  VIR_REQUIRE_DATA(clip, "euroc_MH01_clip30s");
  const Outcome o =
      virSlam("import " + quoted(clip.string()) + " --out " + quoted(path("folder.rawlog")) +
              " --set euroc.max_duration_s=2 --set euroc.other_cameras=false");
  ASSERT_EQ(o.code, 0) << o.text;
  Kept folder = readRawlog(path("folder.rawlog"));
  ASSERT_GE(folder.images.size(), 40u);
  folder.images.pop_back();  // the last one is at the stamp of the last reading
  for (const char* name : {"a.bag", "a.mcap", "a.db3"}) {
    writeBag(folder, path(name));
    const Outcome imported = import(path(name));
    ASSERT_EQ(imported.code, 0) << imported.text;
    const Kept bag = readRawlog(path("x.rawlog"));
    ASSERT_EQ(bag.imu.size(), folder.imu.size()) << name;
    for (std::size_t i = 0; i < bag.imu.size(); ++i) {
      ASSERT_EQ(bag.imu[i].t, folder.imu[i].t);
      ASSERT_EQ(bag.imu[i].gyro, folder.imu[i].gyro);
      ASSERT_EQ(bag.imu[i].acc, folder.imu[i].acc);
    }
    ASSERT_EQ(bag.images.size(), folder.images.size()) << name;
    for (std::size_t i = 0; i < bag.images.size(); ++i) {
      ASSERT_EQ(bag.images[i].first, folder.images[i].first);
      ASSERT_EQ(cv::norm(bag.images[i].second, folder.images[i].second, cv::NORM_INF), 0);
    }
    EXPECT_EQ(bag.camera.fx(), folder.camera.fx());
    EXPECT_EQ(bag.camera.cy(), folder.camera.cy());
    EXPECT_EQ(bag.camera.k2(), folder.camera.k2());
    EXPECT_NEAR((bag.T_B_C.p - folder.T_B_C.p).norm(), 0, 1e-15);
    EXPECT_NEAR(bag.T_B_C.q.angularDistance(folder.T_B_C.q), 0, 1e-7);
  }
}

}  // namespace
}  // namespace vir
