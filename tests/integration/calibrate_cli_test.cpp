/// `vir-slam calibrate uwb` on a recording whose bias is known.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "vir/geometry/pose.h"
#include "vir/ranging/range_bias_model.h"
#include "vir_test_data.h"
#include "vir_test_noise.h"
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

double bias(double d) { return 0.05 + 0.08 * std::exp(-0.5 * d); }

/// As the text of a bias model says.
double noiseIn(const std::string& text) {
  const std::string key = "noise_sigma_m = ";
  return std::stod(text.substr(text.find(key) + key.size()));
}

const Vec3 kAnchors[] = {{2, 1, 2}, {-6, 4, 1}};
const Vec3 kAntenna(0.3, -0.1, 0.2);

Pose poseAt(double t) {
  return {expQuat(Vec3(0.2 * std::sin(t), 0.1, 0.4 * t)),
          Vec3(4 * std::sin(0.31 * t), 3 * std::sin(0.23 * t), 1 + 0.5 * std::sin(0.7 * t))};
}

class CalibrateCli : public testing::Test {
 protected:
  /// 100 s, ground truth at 100 Hz, ranges to two anchors at 20 Hz between its stamps; every 20th
  /// without line of sight.
  void writeRecording(const std::string& name, bool truth = true) {
    rawlog::RawlogWriter writer(path(name));
    test::Noise noise(7);
    for (int i = 0; i < 10000; ++i) {
      const TimeNs t = kStart + 10 * i * kMs;
      if (truth) writer.write(*truthAt(t));
      if (i % 5 == 0) {
        for (const int id : {0, 1}) writer.write(*rangeAt(t + (3 + id) * kMs, id, i, &noise));
      }
    }
    writer.finish();
  }

  static std::shared_ptr<mrpt::obs::CObservationRobotPose> truthAt(TimeNs t) {
    auto out = test::truthAt(t, 0);
    const Pose T = poseAt(toSeconds(t - kStart));
    out->pose.mean = mrpt::poses::CPose3D::FromQuaternionAndTranslation(
        mrpt::math::CQuaternionDouble(T.q.w(), T.q.x(), T.q.y(), T.q.z()), T.p.x(), T.p.y(),
        T.p.z());
    return out;
  }

  static std::shared_ptr<mrpt::obs::CObservationBeaconRanges> rangeAt(TimeNs t, int id, int i,
                                                                      test::Noise* noise) {
    auto out = test::rangeAt(t, id);
    const double d = (kAnchors[id] - poseAt(toSeconds(t - kStart)) * kAntenna).norm();
    double range = d + bias(d) + 0.04 * noise->normal();
    if (i % 100 == 0) range += 0.4 + noise->uniform();
    if (i == 2000) range = -1;
    if (i == 3000) range = std::numeric_limits<float>::quiet_NaN();
    auto& m = out->sensedData[0];
    m.sensedDistance = static_cast<float>(range);
    m.sensorLocationOnRobot = mrpt::poses::CPoint3D(kAntenna.x(), kAntenna.y(), kAntenna.z());
    return out;
  }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  std::string content(const std::string& name) const {
    std::ifstream in(folder_ / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  void write(const std::string& name, const std::string& text) {
    std::ofstream(folder_ / name) << text;
  }

  test::TempFolder folder_;
};

TEST_F(CalibrateCli, FindsTheBiasThatWasPutIn) {
  writeRecording("a.rawlog");
  write("anchors.csv", "# made up\nid,x,y,z\n0,2,1,2\n1,-6,4,1\n");
  const std::string call = "calibrate uwb " + quoted(path("a.rawlog")) + " --anchors " +
                           quoted(path("anchors.csv")) + " --out " + quoted(path("bias.csv")) +
                           " --json " + quoted(path("bias.json"));
  const Outcome o = virSlam(call + " --plot " + quoted(path("bias.svg")));
  ASSERT_EQ(o.code, 0) << o.text;
  const ranging::RangeBiasModel model = ranging::RangeBiasModel::fromText(content("bias.csv"));
  const auto json = nlohmann::json::parse(content("bias.json"));
  const double low = json["distance_m"]["min"], high = json["distance_m"]["max"];
  ASSERT_LT(low, 3);
  ASSERT_GT(high, 9);
  for (double d = low + 0.3; d < high - 0.3; d += 0.2) {
    EXPECT_NEAR(model.at(d).mean_m, bias(d), 0.012) << d;
    EXPECT_LT(model.at(d).sigma_m, 0.02) << d;
  }
  EXPECT_NEAR(noiseIn(content("bias.csv")), 0.04, 0.003);
  EXPECT_EQ(json["ranges"], 4000);
  EXPECT_NEAR(json["outliers"]["too_long"].get<int>(), 196, 8);
  EXPECT_LT(json["outliers"]["too_short"].get<int>(), 8);
  EXPECT_EQ(json["left_out"]["negative"], 2);
  EXPECT_EQ(json["left_out"]["not_finite"], 2);
  EXPECT_LT(json["correlation"]["lag_one"].get<double>(), 0.1);
  EXPECT_TRUE(test::contains(o.text, "sigma of a range")) << o.text;
  EXPECT_TRUE(test::contains(o.text, "bias at 4.00 m")) << o.text;
  EXPECT_TRUE(test::contains(content("bias.svg"), "</svg>"));
  EXPECT_EQ(virSlam(call + " --plot " + quoted(path("bias.png"))).code, 0);
  EXPECT_EQ(content("bias.png").compare(1, 3, "PNG"), 0);
}

TEST_F(CalibrateCli, SeveralRecordingsAndAnchorsFromTheCommandLine) {
  writeRecording("a.rawlog");
  const std::string twice = quoted(path("a.rawlog")) + " " + quoted(path("a.rawlog"));
  const Outcome o = virSlam("calibrate uwb " + twice + " --anchor 0x0,2,1,2 --out " +
                            quoted(path("bias.csv")) + " --json " + quoted(path("o.json")));
  ASSERT_EQ(o.code, 0) << o.text;
  EXPECT_TRUE(test::contains(o.text, "the position of anchor 1 is not given")) << o.text;
  const auto json = nlohmann::json::parse(content("o.json"));
  EXPECT_EQ(json["ranges"], 8000);
  EXPECT_EQ(json["left_out"]["anchor_without_position"], 0);
}

TEST_F(CalibrateCli, WrongUseIsCodeTwo) {
  writeRecording("a.rawlog");
  const std::string good = "calibrate uwb " + quoted(path("a.rawlog"));
  const std::string out = " --out " + quoted(path("b.csv"));
  EXPECT_EQ(virSlam("calibrate").code, 2);
  EXPECT_EQ(virSlam(good + " --anchor 0,2,1,2").code, 2);
  for (const char* bad : {"0,2,1", "0,2,1,x", "0.5,1,1,1", "0xg,1,1,1", "0,1,2,3,4", "0,nan,1,1"}) {
    EXPECT_EQ(virSlam(good + out + " --anchor " + bad).code, 2) << bad;
  }
  EXPECT_EQ(virSlam(good + out + " --anchor 0,1,1,1 --anchor 0,2,2,2").code, 2);
  write("bad.csv", "id,x,y,z\n0,1,2\n");
  const Outcome file = virSlam(good + out + " --anchors " + quoted(path("bad.csv")));
  EXPECT_EQ(file.code, 2);
  EXPECT_TRUE(test::contains(file.text, "bad.csv:2")) << file.text;
  EXPECT_EQ(virSlam("calibrate uwb none.rawlog --anchor 0,2,1,2" + out).code, 2);
  EXPECT_EQ(virSlam("calibrate uwb --help").code, 0);
}

TEST_F(CalibrateCli, AnAnchorThatIsNotGivenIsFoundAndOneThatIsElsewhereIsSaid) {
  writeRecording("a.rawlog");
  const std::string command = "calibrate uwb " + quoted(path("a.rawlog")) + " --out ";
  const Outcome found = virSlam(command + quoted(path("b.csv")));
  EXPECT_EQ(found.code, 0) << found.text;
  EXPECT_TRUE(test::contains(found.text, "the position of anchor 0 is not given")) << found.text;
  const ranging::RangeBiasModel model = ranging::RangeBiasModel::fromText(content("b.csv"));
  // Found with them, the anchors take a constant part of the bias.
  EXPECT_NEAR(model.at(2).mean_m - model.at(6).mean_m, bias(2) - bias(6), 0.03);
  const Outcome wrong = virSlam(command + quoted(path("c.csv")) + " --anchor 0,3,1,2");
  EXPECT_EQ(wrong.code, 1) << wrong.text;
  EXPECT_TRUE(test::contains(wrong.text, "anchor 0 is given at (3.00 1.00 2.00) m")) << wrong.text;
  EXPECT_FALSE(std::filesystem::exists(path("c.csv")));
}

TEST_F(CalibrateCli, TheSampleBehindWallsHasTheBiasOfItsFreeRanges) {
  const std::string sample = test::sourceDir() + "/rawlog/two_A";
  const Outcome o =
      virSlam("calibrate uwb " + quoted(sample + ".rawlog") + " --anchors " +
              quoted(sample + "_anchors_truth.csv") + " --out " + quoted(path("bias.csv")));
  EXPECT_EQ(o.code, 0) << o.text;
  const ranging::RangeBiasModel model = ranging::RangeBiasModel::fromText(content("bias.csv"));
  // At 8 to 9 m nearly all came past an obstacle: 1.09 +- 0.03 m was told.
  for (double d = 2; d < 9.5; d += 0.5) {
    EXPECT_LT(std::abs(model.at(d).mean_m), 0.1 + 3 * model.at(d).sigma_m) << d;
    EXPECT_LT(std::abs(model.at(d).mean_m), 0.4) << d;
  }
}

TEST_F(CalibrateCli, RecordingsThatDoNotServeAreCodeOne) {
  const std::string rest = " --anchor 0,2,1,2 --out " + quoted(path("b.csv"));
  writeRecording("blind.rawlog", false);
  const Outcome blind = virSlam("calibrate uwb " + quoted(path("blind.rawlog")) + rest);
  EXPECT_EQ(blind.code, 1);
  EXPECT_TRUE(test::contains(blind.text, "no ground truth")) << blind.text;
  test::writeRecording(path("norange.rawlog"), 5);
  const Outcome none = virSlam("calibrate uwb " + quoted(path("norange.rawlog")) + rest);
  EXPECT_EQ(none.code, 1);
  EXPECT_TRUE(test::contains(none.text, "no ranges")) << none.text;
  rawlog::RawlogWriter writer(path("few.rawlog"));
  for (int i = 0; i < 10; ++i) {
    writer.write(*truthAt(kStart + i * kMs));
    writer.write(*test::rangeAt(kStart + i * kMs, 0));
  }
  writer.finish();
  const Outcome few = virSlam("calibrate uwb " + quoted(path("few.rawlog")) + rest);
  EXPECT_EQ(few.code, 1);
  EXPECT_TRUE(test::contains(few.text, "at least 30 ranges")) << few.text;
  EXPECT_FALSE(std::filesystem::exists(path("b.csv")));
}

/// Ranges that `import` draws or reads have no bias: the model must find none.
TEST_F(CalibrateCli, AnImportedRecordingWithoutBias) {
  VIR_REQUIRE_DATA(data, "rendered_V102_32s");
  const Outcome import = virSlam("import euroc " + quoted(data.string()) + " --out " +
                                 quoted(path("v102.rawlog")) + " --set euroc.images=link");
  ASSERT_EQ(import.code, 0) << import.text;
  const Outcome o = virSlam("calibrate uwb " + quoted(path("v102.rawlog")) + " --anchors " +
                            quoted((data / "mav0/uwb0/anchors_truth.csv").string()) + " --out " +
                            quoted(path("bias.csv")));
  ASSERT_EQ(o.code, 0) << o.text;
  const ranging::RangeBiasModel model = ranging::RangeBiasModel::fromText(content("bias.csv"));
  EXPECT_NEAR(noiseIn(content("bias.csv")), 0.05, 0.005);
  for (const auto& n : model.nodes()) EXPECT_LT(std::abs(n.bias_m), 0.03 + 3 * n.sigma_m);
}

}  // namespace
}  // namespace vir
