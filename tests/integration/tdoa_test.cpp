/// Differences of ranges (TDoA), from the simulation to a trajectory in the survey's frame.
#include <gtest/gtest.h>

#include <ctime>
#include <fstream>
#include <nlohmann/json.hpp>

#include "vir/rawlog/convert.h"
#include "vir/rawlog/range_differences.h"
#include "vir/rawlog/rawlog_reader.h"
#include "vir_test_paths.h"
#include "vir_test_shell.h"
#include "vir_test_temp_folder.h"
#include "vir_test_whole_files.h"

namespace vir {
namespace {

using test::contains;
using test::quoted;

constexpr const char* kWorld = R"([simulator]
robots = A
tracks = false
images = none
odometry = true
[Robot_A]
flight = eight
[Flight]
length_m = 40
start_m = 1 -2 0.5
start_heading_deg = 77
height_m = 0.3
[SimulatedOdometry]
scale_error = 0.02
yaw_walk = 0.01
position_walk = 0.01
[SimulatedRanges]
anchor_m = 9 7 2.5  -8 6 1.2  -7 -8 3.0  8 -7 0.6
anchor_id = 132 7 5 12
lever_arm_m = 0.03 0 0.08
rate_hz = 10
differences = true
)";

constexpr const char* kSurvey =
    "id,x,y,z,sigma\n0x84,9,7,2.5,0.02\n7,-8,6,1.2,0.02\n5,-7,-8,3,0.02\n12,8,-7,0.6,0.02\n";

class Tdoa : public testing::Test {
 protected:
  void SetUp() override {
    test::writeText(at("world.ini"), kWorld);
    const test::Outcome o = test::virSlam("simulate " + quoted(at("world.ini")) + " --out " +
                                          quoted(at("flight.rawlog")));
    ASSERT_EQ(o.code, 0) << o.text;
    test::writeText(at("anchors.csv"), kSurvey);
  }
  std::string at(const std::string& name) const { return (folder_ / name).string(); }
  test::Outcome run(const std::string& out, const std::string& more) const {
    return test::virSlam("run " + quoted(at("flight.rawlog")) + " --out " + quoted(at(out)) + " " +
                         more);
  }
  nlohmann::json summaryOf(const std::string& out) const {
    std::ifstream in(at(out) + "/summary.json");
    return nlohmann::json::parse(in, nullptr, false);
  }
  test::TempFolder folder_;
};

TEST_F(Tdoa, WithASurveyThePathComesOutInItsFrameAndBetterThanTheOdometry) {
  test::Outcome o = run("with", "--anchors " + quoted(at("anchors.csv")));
  ASSERT_EQ(o.code, 0) << o.text;
  EXPECT_FALSE(contains(o.text, "are not used")) << o.text;
  const auto summary = summaryOf("with");
  EXPECT_EQ(summary["survey"]["status"], "found");
  EXPECT_TRUE(summary["survey"]["findings"].empty()) << summary["survey"];
  for (const auto& a : summary["survey"]["anchors"]) EXPECT_TRUE(a["used"]) << a;
  EXPECT_GT(summary["counters"]["ranges_accepted"], 1000);
  o = run("without", "--set Estimator.use_ranges=false");
  ASSERT_EQ(o.code, 0) << o.text;
  const double error = summary["ate_posyaw_m"], odometry = summaryOf("without")["ate_posyaw_m"];
  EXPECT_LT(error, 0.12);
  EXPECT_LT(error, 0.7 * odometry);
  o = test::virSlam("export " + quoted(at("flight.rawlog")) + " --format tum --out " +
                    quoted(at("tum")));
  ASSERT_EQ(o.code, 0) << o.text;
  o = test::virSlam("evaluate --align none --reference " + quoted(at("tum/GT.tum")) + " " +
                    quoted(at("with/trajectory_survey.tum")) + " --json " + quoted(at("e.json")));
  ASSERT_EQ(o.code, 0) << o.text;
  std::ifstream in(at("e.json"));
  const auto result = nlohmann::json::parse(in, nullptr, false);
  EXPECT_LT(result["estimates"][0]["ate_position_m"]["rmse"], 0.2) << result.dump();
  const std::string ranges = test::readText(at("with/ranges.csv"));
  EXPECT_TRUE(contains(ranges.substr(0, 100), ",decision,reference\n")) << ranges.substr(0, 200);
  EXPECT_TRUE(contains(ranges, ",accepted,132\n"));
}

TEST_F(Tdoa, WithoutASurveyItIsSaidWhatIsMissing) {
  test::Outcome o = run("none", "");
  ASSERT_EQ(o.code, 0) << o.text;
  EXPECT_TRUE(contains(o.text,
                       "differences of ranges (TDoA) to anchors whose places nobody knows "
                       "(5, 7, 12, 132) are not used"))
      << o.text;
  EXPECT_TRUE(contains(o.text, "--anchors anchors.csv")) << o.text;
  const auto counters = summaryOf("none")["counters"];
  EXPECT_EQ(counters["range_differences"], counters["range_differences_without_a_place"]);
  test::writeText(at("two.csv"), "id,x,y,z\n0x84,9,7,2.5\n7,-8,6,1.2\n");
  o = run("two", "--anchors " + quoted(at("two.csv")));
  ASSERT_EQ(o.code, 0) << o.text;
  EXPECT_TRUE(contains(o.text, "three of its anchors")) << o.text;
}

/// Ranges and differences are never taken for one another, and a table gives back what it was.
TEST_F(Tdoa, TheRawlogTellsThemFromRanges) {
  rawlog::RawlogReader reader(at("flight.rawlog"));
  long differences = 0, negative = 0;
  while (const auto o = reader.next()) {
    EXPECT_TRUE(rawlog::rangesOf(*o).empty());
    for (const Range& r : rawlog::rangeDifferencesOf(*o)) {
      ASSERT_TRUE(r.reference);
      EXPECT_EQ(o->sensorLabel, "TDOA:" + std::to_string(*r.reference));
      EXPECT_EQ(r.p_B_U.cast<float>(), Vec3(0.03, 0, 0.08).cast<float>());
      ++differences;
      negative += r.range_m < 0;
    }
  }
  EXPECT_GT(differences, 1000);
  EXPECT_GT(negative, differences / 4);
  test::Outcome o = test::virSlam("export " + quoted(at("flight.rawlog")) + " --format csv --out " +
                                  quoted(at("csv")));
  ASSERT_EQ(o.code, 0) << o.text;
  o = test::virSlam("check " + quoted(at("flight.rawlog")));
  EXPECT_TRUE(contains(o.text, "TDOA:132")) << o.text;
  EXPECT_TRUE(contains(o.text, "--anchors")) << o.text;
}

/// From a radio on a pseudo-terminal, while recording, to an estimate in the survey's frame.
TEST_F(Tdoa, LiveFromADevice) {
  const long start_s = static_cast<long>(time(nullptr)) + 3;
  const std::string started = std::to_string(start_s), radio = at("radio");
  test::writeText(at("live.ini"),
                  "[Recording]\nestimate = true\n[Estimator]\ndriver = odometry\n"
                  "[wheels]\ndriver = RawlogReplay\nprocess_rate = 200\nlabels = ODOM GT\n"
                  "clock = keep\nstamps = now\nrawlog = flight.rawlog\nstart_at_s = " +
                      started +
                      "\n[tag]\ndriver = UwbSerial\nprocess_rate = 500\nprotocol = json\n"
                      "anchor_ids = 0x84 7 5 12\nantenna_m = 0.03 0 0.08\nport = " +
                      radio + "\n");
  const std::string call =
      quoted(test::buildDir() + "/bin/vir-device-emulator") + " " + quoted(at("flight.rawlog")) +
      " --no-wait --start-at " + started + " --uwb json=" + radio + " > " + quoted(at("sent")) +
      " & radio=$!; for i in 1 2 3 4 5 6 7 8 9; do [ -e " + quoted(radio) +
      " ] || sleep 0.1; done; " + quoted(test::buildDir() + "/bin/vir-slam") + " record " +
      quoted(at("live.ini")) + " --out " + quoted(at("live.rawlog")) + " --results " +
      quoted(at("live")) + " --duration-s 33 --set " +
      quoted("Ranges.surveyed_anchors=" + at("anchors.csv")) + "; code=$?; kill $radio; exit $code";
  const test::Outcome o = test::shell(call);
  ASSERT_EQ(o.code, 0) << o.text;
  EXPECT_TRUE(contains(o.text, "tag: differences ")) << o.text;
  EXPECT_FALSE(contains(o.text, "corrupt")) << o.text;
  const auto summary = summaryOf("live");
  EXPECT_EQ(summary["survey"]["status"], "found") << summary["survey"];
  EXPECT_GT(summary["counters"]["ranges_accepted"], 500) << summary["counters"];
  EXPECT_LT(summary["ate_posyaw_m"], 0.15);
}

}  // namespace
}  // namespace vir
