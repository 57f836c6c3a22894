#include "recording.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "input_error.h"
#include "vir_test_euroc_folder.h"

namespace vir::euroc {
namespace {

using test::EurocFolder;
using test::EurocFolderOptions;

struct Content {
  std::vector<Event> events;
  std::vector<ImuSample> imu;
  std::vector<RangeRow> ranges;
  std::vector<PoseRow> truth;
  std::vector<ImageRow> images;
  ProblemLog log;
  bool in_order = true;
};

EurocOptions optionsFor(const EurocFolder& f) {
  EurocOptions o;
  o.source = f.root().string();
  return o;
}

Content readAll(const EurocOptions& o) {
  Content c;
  Recording recording(o, &c.log);
  Event e;
  TimeNs last = 0;
  while (recording.next(&e)) {
    c.in_order = c.in_order && e.t >= last;
    last = e.t;
    c.events.push_back(e);
    if (auto* imu = std::get_if<ImuSample>(&e.what)) c.imu.push_back(*imu);
    if (auto* range = std::get_if<RangeRow>(&e.what)) c.ranges.push_back(*range);
    if (auto* pose = std::get_if<PoseRow>(&e.what)) c.truth.push_back(*pose);
    if (auto* image = std::get_if<ImageRow>(&e.what)) c.images.push_back(*image);
  }
  EXPECT_DOUBLE_EQ(recording.progress(), 1.0);
  return c;
}

std::string errorOf(const EurocOptions& o) {
  ProblemLog log;
  try {
    Recording recording(o, &log);
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(Recording, MergesEverythingInTimeOrder) {
  const EurocFolder f;
  const Content c = readAll(optionsFor(f));
  EXPECT_EQ(c.images.size(), 10u);
  EXPECT_EQ(c.imu.size(), static_cast<std::size_t>(f.imuRows()));
  EXPECT_EQ(c.truth.size(), static_cast<std::size_t>(f.imuRows()));
  // The last range lies behind the last image, and is still there.
  EXPECT_EQ(c.ranges.size(), 10u);
  EXPECT_TRUE(c.in_order);
  EXPECT_TRUE(c.log.messages().empty()) << c.log.messages().front();
  EXPECT_EQ(c.images[3].t, f.imageStamp(3));
  EXPECT_EQ(c.images[3].file, std::to_string(f.imageStamp(3)) + ".png");
  EXPECT_DOUBLE_EQ(c.imu[7].gyro.x(), 0.007);
  EXPECT_DOUBLE_EQ(c.imu[7].gyro.z(), 0.03);
  EXPECT_DOUBLE_EQ(c.imu[7].acc.x(), 0.1);
  EXPECT_DOUBLE_EQ(c.imu[7].acc.z(), 9.81);
  EXPECT_EQ(c.ranges[2].anchor, 3);
  EXPECT_DOUBLE_EQ(c.ranges[2].range_m, 2.52);
  EXPECT_NEAR(c.truth[20].T_W_B.p.x(), 0.1, 1e-9);
  EXPECT_NEAR(yawOf(c.truth[20].T_W_B.R()), 0.05, 1e-8);
}

TEST(Recording, AtOneStampTheImuComesBeforeTheImage) {
  const EurocFolder f;
  const Content c = readAll(optionsFor(f));
  for (std::size_t i = 1; i < c.events.size(); ++i) {
    if (c.events[i].t != c.events[i - 1].t) continue;
    EXPECT_LT(c.events[i - 1].what.index(), c.events[i].what.index()) << i;
  }
}

TEST(Recording, TheFolderMayBeMav0Itself) {
  const EurocFolder f;
  EurocOptions o = optionsFor(f);
  o.source = f.mav0().string() + "/";
  EXPECT_EQ(readAll(o).images.size(), 10u);
}

TEST(Recording, CarriageReturnsChangeNothing) {
  EurocFolderOptions fo;
  fo.line_end = "\r\n";
  const EurocFolder f(fo);
  const Content c = readAll(optionsFor(f));
  EXPECT_EQ(c.images.size(), 10u);
  EXPECT_EQ(c.imu.size(), static_cast<std::size_t>(f.imuRows()));
  EXPECT_TRUE(c.log.counters().empty());
}

TEST(Recording, AHeaderWithoutHashIsAHeader) {
  const EurocFolder f;
  f.replace("imu0/data.csv", "#timestamp", "timestamp");
  const Content c = readAll(optionsFor(f));
  EXPECT_EQ(c.imu.size(), static_cast<std::size_t>(f.imuRows()));
  EXPECT_TRUE(c.log.counters().empty());
}

TEST(Recording, FaultyImuRowsAreCountedAndNamedByLine) {
  const EurocFolder f;
  const std::string row = f.row("imu0/data.csv", 5);
  f.replace("imu0/data.csv", row + "\n",
            row.substr(0, 19) + ",nan,0,0,0,0,9.81\n" +       // line 7
                row.substr(0, 19) + ",0,0,0,inf,0,9.81\n" +   // line 8
                row.substr(0, 19) + ",0,0,0\n" +              // line 9
                row.substr(0, 19) + ",0,0,x,0,0,9.81\n" +     // line 10
                "abc,0,0,0,0,0,9.81\n" +                      // line 11
                row.substr(0, 19) + ",1e30,0,0,0,0,9.81\n");  // line 12
  const Content c = readAll(optionsFor(f));
  EXPECT_EQ(c.imu.size(), static_cast<std::size_t>(f.imuRows() - 1));
  EXPECT_EQ(c.log.get("imu_not_finite"), 2);
  EXPECT_EQ(c.log.get("imu_malformed"), 3);
  EXPECT_EQ(c.log.get("imu_implausible"), 1);
  EXPECT_TRUE(contains(c.log.first("imu_not_finite"), "data.csv:7: column 2"))
      << c.log.first("imu_not_finite");
  EXPECT_TRUE(contains(c.log.first("imu_malformed"), "data.csv:9: has 4 columns, needs 7"));
  for (const ImuSample& r : c.imu) EXPECT_TRUE(r.gyro.allFinite() && r.acc.allFinite());
}

TEST(Recording, AKindOfFaultHasOneMessageWithItsCount) {
  const EurocFolder f;
  for (int i = 0; i < 20; ++i) f.append("imu0/data.csv", "broken line\n");
  const Content c = readAll(optionsFor(f));
  EXPECT_EQ(c.log.get("imu_malformed"), 20);
  ASSERT_EQ(c.log.messages().size(), 1u);
  EXPECT_TRUE(contains(c.log.messages()[0], "data.csv:" + std::to_string(f.imuRows() + 2) + ": "))
      << c.log.messages()[0];
  EXPECT_TRUE(contains(c.log.messages()[0], " (and 19 more like this)")) << c.log.messages()[0];
}

TEST(Recording, ALineCutAtTheEndIsNotUsed) {
  const EurocFolder f;
  const std::string text = f.read("imu0/data.csv");
  f.write("imu0/data.csv", text.substr(0, text.size() - 4));  // ",9.81\n" becomes ",9"
  const Content c = readAll(optionsFor(f));
  EXPECT_EQ(c.imu.size(), static_cast<std::size_t>(f.imuRows() - 1));
  EXPECT_EQ(c.log.get("imu_cut_line"), 1);
}

TEST(Recording, AnImageListMayEndWithoutALineBreak) {
  const EurocFolder f;
  std::string text = f.read("cam0/data.csv");
  text.pop_back();
  f.write("cam0/data.csv", text);
  EXPECT_EQ(readAll(optionsFor(f)).images.size(), 10u);
}

TEST(Recording, RowsOutOfOrderAreSorted) {
  const EurocFolder f;
  const std::string a = f.row("imu0/data.csv", 10), b = f.row("imu0/data.csv", 14);
  f.replace("imu0/data.csv", a, "A");
  f.replace("imu0/data.csv", b, a);
  f.replace("imu0/data.csv", "\nA\n", "\n" + b + "\n");
  const Content c = readAll(optionsFor(f));
  EXPECT_EQ(c.imu.size(), static_cast<std::size_t>(f.imuRows()));
  EXPECT_TRUE(c.in_order);
  EXPECT_GE(c.log.get("imu_out_of_order"), 1);
}

TEST(Recording, ARowFarTooLateIsSkipped) {
  const EurocFolder f;
  const std::string first = f.row("imu0/data.csv", 0);
  f.append("imu0/data.csv", f.row("imu0/data.csv", 1) + "\n");
  const Content c = readAll(optionsFor(f));
  EXPECT_TRUE(c.in_order);
  EXPECT_EQ(c.imu.size(), static_cast<std::size_t>(f.imuRows()));
  EXPECT_EQ(c.log.get("imu_too_late"), 1);
}

TEST(Recording, RepeatedStampsCountOnce) {
  const EurocFolder f;
  const std::string imu = f.row("imu0/data.csv", 3), image = f.row("cam0/data.csv", 4);
  f.replace("imu0/data.csv", imu + "\n", imu + "\n" + imu + "\n");
  f.replace("cam0/data.csv", image + "\n", image + "\n" + image + "\n");
  const Content c = readAll(optionsFor(f));
  EXPECT_EQ(c.imu.size(), static_cast<std::size_t>(f.imuRows()));
  EXPECT_EQ(c.images.size(), 10u);
  EXPECT_EQ(c.log.get("imu_repeated"), 1);
  EXPECT_EQ(c.log.get("image_repeated"), 1);
}

TEST(Recording, TwoAnchorsMayAnswerAtOneTime) {
  const EurocFolder f;
  const std::string row = f.row("uwb0/data.csv", 2);
  const std::string stamp = row.substr(0, 19);
  f.replace("uwb0/data.csv", row + "\n", row + "\n" + stamp + ",4,3.5\n" + stamp + ",4,3.6\n");
  const Content c = readAll(optionsFor(f));
  EXPECT_EQ(c.ranges.size(), 11u);
  EXPECT_EQ(c.log.get("range_repeated"), 1);
}

TEST(Recording, AbsurdRangesAreSkipped) {
  const EurocFolder f;
  f.append("uwb0/data.csv",
           "1403636590000000000,3,-1.0\n1403636590000000001,3,1e9\n1403636590000000002,3.5,1\n"
           "1403636590000000003,3,nan\n1403636590000000004,3\n");
  const Content c = readAll(optionsFor(f));
  EXPECT_EQ(c.ranges.size(), 10u);
  EXPECT_EQ(c.log.get("range_implausible"), 2);
  EXPECT_EQ(c.log.get("range_malformed"), 2);
  EXPECT_EQ(c.log.get("range_not_finite"), 1);
}

TEST(Recording, GapsAreReported) {
  const EurocFolder f;
  // 2 s without IMU and without images.
  f.append("imu0/data.csv", "1403636582500000123,0,0,0,0,0,9.81\n");
  f.append("cam0/data.csv", "1403636582500000123,x.png\n");
  const Content c = readAll(optionsFor(f));
  EXPECT_EQ(c.log.get("imu_gap"), 1);
  EXPECT_EQ(c.log.get("image_gap"), 1);
  EXPECT_TRUE(contains(c.log.first("imu_gap"), "2.050 s"));
}

TEST(Recording, GroundTruthAsTumText) {
  const EurocFolder f;
  std::filesystem::remove(f.mav0() / "state_groundtruth_estimate0/data.csv");
  f.write("state_groundtruth_estimate0/gt.txt",
          "# time x y z qx qy qz qw\n1403636580.000000123 1 2 3 0 0 0.6 0.8\n"
          "1403636580.00501 1 2 3 0 0 0 1\n1403636580.1 1 2 3 0 0 0 2\n");
  const Content c = readAll(optionsFor(f));
  ASSERT_EQ(c.truth.size(), 2u);
  EXPECT_EQ(c.truth[0].t, 1403636580000000123);
  EXPECT_EQ(c.truth[1].t, 1403636580005010000);
  EXPECT_NEAR(c.truth[0].T_W_B.q.w(), 0.8, 1e-12);
  EXPECT_NEAR(c.truth[0].T_W_B.q.z(), 0.6, 1e-12);
  EXPECT_EQ(c.log.get("ground_truth_implausible"), 1);  // the quaternion of length 2
}

TEST(Recording, AnImuThatIsNotTheBodyMovesEverythingElse) {
  const EurocFolder f;
  // IMU turned by 90 deg about z and 0.2 m up: T_B_I.
  f.replace("imu0/sensor.yaml", EurocFolder::kIdentity, "0,-1,0,0, 1,0,0,0, 0,0,1,0.2, 0,0,0,1");
  ProblemLog log;
  Recording r(optionsFor(f), &log);
  // Camera at (0.1, 0.02, 0.03) in B is at R^T (p - t) in I.
  EXPECT_LT((r.cameras()[0].calibration.T_B_C.p - Vec3(0.02, -0.1, -0.17)).norm(), 1e-12);
  EXPECT_LT((r.rangeStreams()[0].antenna - Vec3(0.2, -0.1, 0.1)).norm(), 1e-12);
  Event e;
  while (r.next(&e) && !std::holds_alternative<PoseRow>(e.what)) {
  }
  const Pose T = std::get<PoseRow>(e.what).T_W_B;
  EXPECT_NEAR(T.p.z(), 1.7, 1e-9);
  EXPECT_NEAR(yawOf(T.R()), 1.5707963, 1e-6);
  ASSERT_EQ(log.messages().size(), 1u);
  EXPECT_TRUE(contains(log.messages()[0], "not the identity"));
}

TEST(Recording, StartAndDurationCutTheRecording) {
  const EurocFolder f;
  EurocOptions o = optionsFor(f);
  o.start_s = 0.1;
  o.max_duration_s = 0.2;
  const Content c = readAll(o);
  ASSERT_EQ(c.images.size(), 5u);
  EXPECT_EQ(c.images.front().t, f.imageStamp(2));
  EXPECT_GE(c.imu.front().t, f.imageStamp(2));
  EXPECT_LE(c.imu.back().t, f.imageStamp(6));
  o.start_s = 100;
  EXPECT_TRUE(contains(errorOf(o), "start_s"));
}

TEST(Recording, SettingsSwitchParts) {
  const EurocFolder f;
  EurocOptions o = optionsFor(f);
  o.read_gt = o.read_ranges = false;
  o.camera = "none";
  const Content c = readAll(o);
  EXPECT_EQ(c.events.size(), c.imu.size());
  EXPECT_EQ(c.imu.size(), static_cast<std::size_t>(f.imuRows()));
}

TEST(Recording, TumViLayout) {
  EurocFolderOptions fo;
  fo.tum_vi = true;
  fo.ranges = false;
  const EurocFolder f(fo);
  std::filesystem::remove(f.mav0() / "imu0/sensor.yaml");
  const Content c = readAll(optionsFor(f));
  EXPECT_EQ(c.images.size(), 10u);
  EXPECT_EQ(c.truth.size(), static_cast<std::size_t>(f.imuRows()));
  ASSERT_EQ(c.log.messages().size(), 1u);
  EXPECT_TRUE(contains(c.log.messages()[0], "imu0/sensor.yaml: missing"));
}

/// Its calibration is one file of Kalibr's for both cameras.
TEST(Recording, TumViHasItsCamerasInOneFile) {
  namespace fs = std::filesystem;
  EurocFolderOptions fo;
  fo.tum_vi = true;
  fo.ranges = false;
  const EurocFolder f(fo);
  fs::remove(f.mav0() / "cam0/sensor.yaml");
  fs::copy(f.mav0() / "cam0", f.mav0() / "cam1", fs::copy_options::recursive);
  EXPECT_TRUE(contains(errorOf(optionsFor(f)), "cam0/sensor.yaml: no such file"));
  const auto camera = [](int i, const std::string& place) {
    return "cam" + std::to_string(i) + ":\n  camera_model: pinhole\n  intrinsics: [4" +
           std::to_string(i) +
           ", 41, 31, 23]\n  distortion_model: equidistant\n"
           "  distortion_coeffs: [0.01, 0, 0, 0]\n  resolution: [64, 48]\n" +
           place;
  };
  const std::string turned = ": [[1,0,0,0.1],[0,1,0,0],[0,0,1,0],[0,0,0,1]]\n";
  fs::create_directory(f.root() / "dso");
  const auto chain = [&](const std::string& second) {
    test::writeText(f.root() / "dso/camchain.yaml", camera(0, "  T_cam_imu" + turned) + second);
  };
  chain(camera(1, "  T_cn_cnm1" + turned));
  ProblemLog log;
  const Recording recording(optionsFor(f), &log);
  const auto& both = recording.cameras();
  ASSERT_EQ(both.size(), 2u);
  EXPECT_EQ(both[0].calibration.camera.fx, 40);
  EXPECT_EQ(both[1].calibration.camera.fx, 41);
  EXPECT_NEAR((both[1].calibration.T_B_C.p - Vec3(-0.2, 0, 0)).norm(), 0, 1e-12);
  chain("");
  ProblemLog one;
  const Recording alone(optionsFor(f), &one);
  EXPECT_EQ(alone.cameras().size(), 1u);
  std::string said;
  for (const std::string& m : one.messages()) said += m + "\n";
  EXPECT_TRUE(contains(said, "cam1: not read, it has no sensor.yaml and is not whole in ")) << said;
}

TEST(RecordingErrors, SayWhatIsMissing) {
  EurocOptions o;
  EXPECT_TRUE(contains(errorOf(o), "source is empty"));
  test::TempFolder empty;
  o.source = empty.path().string();
  EXPECT_TRUE(contains(errorOf(o), "holds no folder mav0"));
  o.source = "/nonexistent/folder";
  EXPECT_TRUE(contains(errorOf(o), "no such folder"));
  const EurocFolder f;
  o = optionsFor(f);
  o.camera = "cam7";
  EXPECT_TRUE(contains(errorOf(o), "it holds cam0, imu0"));
  o.source = f.imageFile(0).string();
  EXPECT_TRUE(contains(errorOf(o), "is a file"));
}

TEST(RecordingErrors, MissingPartsAndUselessFiles) {
  const EurocFolder f;
  const EurocOptions o = optionsFor(f);
  const std::string imu = f.read("imu0/data.csv"), cam = f.read("cam0/sensor.yaml");
  f.write("imu0/data.csv", "#timestamp\n");
  EXPECT_TRUE(contains(errorOf(o), "no usable row"));
  f.write("imu0/data.csv", std::string(100'000, '\xFF'));
  EXPECT_TRUE(contains(errorOf(o), "no usable row; first problem"));
  std::filesystem::remove(f.mav0() / "imu0/data.csv");
  EXPECT_TRUE(contains(errorOf(o), "imu0/data.csv: no such file"));
  f.write("imu0/data.csv", imu);
  std::filesystem::remove(f.mav0() / "cam0/sensor.yaml");
  EXPECT_TRUE(contains(errorOf(o), "cam0/sensor.yaml"));
  f.write("cam0/sensor.yaml", cam);
  EXPECT_EQ(errorOf(o), "");
  std::filesystem::remove_all(f.mav0() / "imu0");
  EXPECT_TRUE(contains(errorOf(o), "no folder imu0"));
}

}  // namespace
}  // namespace vir::euroc
