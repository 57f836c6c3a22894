/// `run --save-map`, `run --map` and `map` as a user calls them, with the recording in rawlog/.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "end_to_end.h"
#include "vir/mission/mission_map.h"
#include "vir_test_paths.h"

namespace vir {
namespace {

using test::contains;
using test::Outcome;
using test::quoted;
using test::RunResult;
using test::virSlam;

class MapCli : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new test::TempFolder;
    first_ = new RunResult(run("first", "--save-map " + quoted(file("a.virmap"))));
  }
  static void TearDownTestSuite() {
    delete first_;
    delete folder_;
  }
  static std::string file(const std::string& name) { return (*folder_ / name).string(); }
  static RunResult run(const std::string& name, const std::string& more) {
    return test::runVir(test::sourceDir() + "/rawlog/two_A.rawlog", file(name), more);
  }
  static test::TempFolder* folder_;
  static RunResult* first_;
};
test::TempFolder* MapCli::folder_ = nullptr;
RunResult* MapCli::first_ = nullptr;

TEST_F(MapCli, ARunLeavesAMap) {
  ASSERT_EQ(first_->outcome.code, 0) << first_->outcome.text;
  for (const char* name : {"loops.csv", "trajectory_odom.tum"}) {
    EXPECT_TRUE(std::filesystem::exists(first_->folder + "/" + name)) << name;
  }
  ASSERT_TRUE(first_->summary.contains("loops"));
  EXPECT_TRUE(first_->summary["loops"].contains("accepted"));
  EXPECT_TRUE(first_->summary["loops"].contains("rejected"));
  const Outcome info = virSlam("map info " + quoted(file("a.virmap")));
  EXPECT_EQ(info.code, 0) << info.text;
  EXPECT_TRUE(contains(info.text, "keyframes")) << info.text;
  EXPECT_TRUE(contains(info.text, "480 x 320 px")) << info.text;
}

TEST_F(MapCli, WithoutLoopsNothingOfThemIsWritten) {
  const RunResult plain = run("plain", "--set Estimator.loops=false");
  ASSERT_EQ(plain.outcome.code, 0) << plain.outcome.text;
  EXPECT_FALSE(plain.summary.contains("loops"));
  EXPECT_FALSE(std::filesystem::exists(plain.folder + "/loops.csv"));
  EXPECT_FALSE(std::filesystem::exists(plain.folder + "/trajectory_odom.tum"));
}

/// The same flight again: its poses come to lie on those of the map, and the same input gives the
/// same bytes.
TEST_F(MapCli, TheNextRunIsFoundInIt) {
  const std::string map = "--map " + quoted(file("a.virmap"));
  const RunResult second = run("second", map + " --save-map " + quoted(file("ab.virmap")));
  ASSERT_EQ(second.outcome.code, 0) << second.outcome.text;
  EXPECT_GE(second.summary["loops"]["accepted"], 5);
  EXPECT_FALSE(second.warns("was not found in the map"));
  ASSERT_FALSE(second.trajectory.empty());
  ASSERT_EQ(second.trajectory.size(), first_->trajectory.size());
  EXPECT_LT((second.trajectory.back().T_W_B.p - first_->trajectory.back().T_W_B.p).norm(), 0.2);
  const RunResult third = run("third", map);
  for (const char* name : {"trajectory.tum", "trajectory_smoothed.tum", "loops.csv"}) {
    EXPECT_EQ(test::readText(second.folder + "/" + name), test::readText(third.folder + "/" + name))
        << name;
  }
  const Outcome merged =
      virSlam("map merge " + quoted(file("a.virmap")) + " " + quoted(file("ab.virmap")) +
              " --out " + quoted(file("abc.virmap")));
  EXPECT_EQ(merged.code, 0) << merged.text;
  EXPECT_TRUE(contains(merged.text, "joined by")) << merged.text;
  // Both runs saw the same images: few keyframes are new.
  const std::size_t of_a = mission::loadMap(file("a.virmap")).keyframes.size();
  const std::size_t of_all = mission::loadMap(file("abc.virmap")).keyframes.size();
  EXPECT_GE(of_all, of_a);
  EXPECT_LT(of_all, of_a + of_a / 3);
}

/// Live it is the same: found in the map of the recording that is played, and a map at the end.
TEST_F(MapCli, ALiveRunTakesAMapAndLeavesOne) {
  std::string record = "record " + quoted(test::sourceDir() + "/ini/live_replay.ini") + " --out " +
                       quoted(file("live.rawlog")) + " --results " + quoted(file("live")) +
                       " --save-map " + quoted(file("live.virmap"));
  for (const char* sensor : {"camera", "imu", "uwb", "truth"}) {
    record += " --set replay_" + std::string(sensor) + ".speed=2";
  }
  const Outcome none = virSlam(record + " --map " + quoted(file("none.virmap")));
  EXPECT_EQ(none.code, 2) << none.text;
  EXPECT_TRUE(contains(none.text, "none.virmap")) << none.text;
  const Outcome outcome = virSlam(record + " --map " + quoted(file("a.virmap")));
  ASSERT_EQ(outcome.code, 0) << outcome.text;
  const auto summary = nlohmann::json::parse(test::readText(file("live/summary.json")));
  EXPECT_GE(summary["loops"]["accepted"].get<long>(), 3) << outcome.text;
  const Outcome info = virSlam("map info " + quoted(file("live.virmap")));
  EXPECT_EQ(info.code, 0) << info.text;
}

/// One without a keyframe, and one without a pose: the map of before
/// stays, and one that was never there does not come to be.
TEST_F(MapCli, ARunThatSawNoPlaceLeavesTheMapAlone) {
  const std::string kept = file("kept.virmap"), fresh = file("fresh.virmap");
  std::filesystem::copy_file(file("a.virmap"), kept);
  RunResult r = run("short", "--save-map " + quoted(kept) + " --set Estimator.duration_s=1.3");
  EXPECT_EQ(r.outcome.code, 0) << r.outcome.text;
  EXPECT_TRUE(r.warns("kept.virmap is not written")) << r.summary["warnings"];
  EXPECT_TRUE(r.warns("stays as it was")) << r.summary["warnings"];
  EXPECT_EQ(test::readText(kept), test::readText(file("a.virmap")));
  r = run("short_fresh", "--save-map " + quoted(fresh) + " --set Estimator.duration_s=0.3");
  EXPECT_EQ(r.outcome.code, 1) << r.outcome.text;
  EXPECT_TRUE(r.warns("fresh.virmap is not written")) << r.summary["warnings"];
  EXPECT_FALSE(r.warns("stays as it was")) << r.summary["warnings"];
  EXPECT_FALSE(std::filesystem::exists(fresh));
}

/// As were written before: no run can be found in one, which is said before it begins.
TEST_F(MapCli, AMapWithoutAPlaceIsRefused) {
  mission::MissionMap map = mission::loadMap(file("a.virmap"));
  map.keyframes.clear();
  test::writeText(file("empty.virmap"), mission::encode(map));
  const RunResult r = run("empty", "--map " + quoted(file("empty.virmap")));
  EXPECT_EQ(r.outcome.code, 2) << r.outcome.text;
  EXPECT_TRUE(contains(r.outcome.text, "empty.virmap")) << r.outcome.text;
  EXPECT_TRUE(contains(r.outcome.text, "holds no place")) << r.outcome.text;
  const Outcome info = virSlam("map info " + quoted(file("empty.virmap")));
  EXPECT_EQ(info.code, 2) << info.text;
  EXPECT_TRUE(contains(info.text, "holds no place")) << info.text;
}

/// The recording's own calibration, and one that is given, tell it before anything is written.
TEST_F(MapCli, AMapOfAnotherCameraIsRefusedAtTheStart) {
  mission::MissionMap map = mission::loadMap(file("a.virmap"));
  map.calibration.camera.fx *= 1.1;
  map.calibration.camera.fy *= 1.1;
  test::writeText(file("other.virmap"), mission::encode(map));
  const RunResult r = run("other", "--map " + quoted(file("other.virmap")));
  EXPECT_EQ(r.outcome.code, 2) << r.outcome.text;
  EXPECT_TRUE(contains(r.outcome.text, "of another camera")) << r.outcome.text;
  EXPECT_TRUE(contains(r.outcome.text, "focal length")) << r.outcome.text;
  EXPECT_FALSE(std::filesystem::exists(r.folder));
}

/// The same places with nothing alike to be seen: of a run in another place, as it were.
TEST_F(MapCli, ARunThatWasNotFoundLeavesItsMapAlone) {
  mission::MissionMap map = mission::loadMap(file("a.virmap"));
  for (auto& k : map.keyframes) {
    auto copy = std::make_shared<PlaceKeyframe>(*k);
    for (PlacePoint& p : copy->points) {
      for (std::size_t i = 0; i < p.descriptor.size(); ++i) p.descriptor[i] ^= (i % 2) * 0xff;
    }
    k = std::move(copy);
  }
  const std::string bytes = mission::encode(map);
  test::writeText(file("strange.virmap"), bytes);
  const std::string strange = quoted(file("strange.virmap"));
  const RunResult r = run("strange", "--map " + strange + " --save-map " + strange);
  EXPECT_EQ(r.outcome.code, 0) << r.outcome.text;
  EXPECT_TRUE(r.warns("strange.virmap stays as it was")) << r.summary["warnings"];
  EXPECT_TRUE(test::readText(file("strange.virmap")) == bytes);
}

/// Itself, and one that extends it: nothing is there twice.
TEST_F(MapCli, WhatTwoMapsHoldOfOneRunIsTakenOnce) {
  const std::string a = quoted(file("a.virmap")), twice = file("twice.virmap");
  const Outcome merged = virSlam("map merge " + a + " " + a + " --out " + quoted(twice));
  EXPECT_EQ(merged.code, 0) << merged.text;
  EXPECT_TRUE(contains(merged.text, "of the same images")) << merged.text;
  EXPECT_EQ(mission::loadMap(twice).keyframes.size(),
            mission::loadMap(file("a.virmap")).keyframes.size());
}

TEST_F(MapCli, WhatIsWrongIsSaid) {
  std::string bytes = test::readText(file("a.virmap"));
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
  test::writeText(file("bad.virmap"), bytes);
  Outcome outcome = virSlam("map info " + quoted(file("bad.virmap")));
  EXPECT_EQ(outcome.code, 2);
  EXPECT_TRUE(contains(outcome.text, "bad.virmap")) << outcome.text;
  EXPECT_TRUE(contains(outcome.text, "checksum")) << outcome.text;
  outcome = virSlam("map merge " + quoted(file("a.virmap")) + " " + quoted(file("bad.virmap")) +
                    " --out " + quoted(file("merged.virmap")));
  EXPECT_EQ(outcome.code, 2) << outcome.text;
  EXPECT_TRUE(contains(outcome.text, "bad.virmap")) << outcome.text;
  EXPECT_FALSE(std::filesystem::exists(file("merged.virmap")));
  RunResult r = run("bad", "--map " + quoted(file("bad.virmap")));
  EXPECT_EQ(r.outcome.code, 2) << r.outcome.text;
  EXPECT_TRUE(contains(r.outcome.text, "checksum")) << r.outcome.text;
  r = run("none", "--map " + quoted(file("none.virmap")));
  EXPECT_EQ(r.outcome.code, 2) << r.outcome.text;
  EXPECT_TRUE(contains(r.outcome.text, "none.virmap")) << r.outcome.text;
  r = run("nowhere", "--save-map " + quoted(file("no/where.virmap")));
  EXPECT_EQ(r.outcome.code, 2) << r.outcome.text;
  r = run("folder", "--save-map " + quoted(file("")));
  EXPECT_EQ(r.outcome.code, 2) << r.outcome.text;
  EXPECT_TRUE(contains(r.outcome.text, "is a folder")) << r.outcome.text;
  r = run("blind", "--save-map " + quoted(file("b.virmap")) + " --set Estimator.driver=odometry");
  EXPECT_EQ(r.outcome.code, 2) << r.outcome.text;
  EXPECT_TRUE(contains(r.outcome.text, "no images")) << r.outcome.text;
  EXPECT_EQ(virSlam("map info " + quoted(file("none.virmap"))).code, 2);
  EXPECT_EQ(virSlam("map merge " + quoted(file("a.virmap")) + " --out " + quoted(file("m"))).code,
            2);
  for (const auto& [place, said] :
       {std::pair{"no/where.virmap", "there is no folder"}, std::pair{"", "is a folder"}}) {
    outcome = virSlam("map merge " + quoted(file("a.virmap")) + " " + quoted(file("a.virmap")) +
                      " --out " + quoted(file(place)));
    EXPECT_EQ(outcome.code, 2) << outcome.text;
    EXPECT_TRUE(contains(outcome.text, said)) << outcome.text;
    EXPECT_FALSE(contains(outcome.text, "joined")) << "said before any work: " << outcome.text;
  }
  // What is the user's own is not written over.
  test::writeText(file("mine.txt"), "a letter");
  outcome = virSlam("map merge " + quoted(file("a.virmap")) + " " + quoted(file("a.virmap")) +
                    " --out " + quoted(file("mine.txt")));
  EXPECT_EQ(outcome.code, 2) << outcome.text;
  EXPECT_EQ(test::readText(file("mine.txt")), "a letter");
}

}  // namespace
}  // namespace vir
