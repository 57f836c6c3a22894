/// vir-slam rendezvous of robots whose images show the same places, with the recordings in rawlog/.
#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "vir_test_paths.h"
#include "vir_test_shell.h"
#include "vir_test_temp_folder.h"

namespace vir {
namespace {

namespace fs = std::filesystem;
using test::contains;
using test::Outcome;
using test::quoted;
using Json = nlohmann::json;

const std::string kSample = test::sourceDir() + "/rawlog/two_";
/// A label that no range has, and no anchor: images alone.
const std::string kImagesAlone =
    "--set Rendezvous.peer_label=NOBODY --set Rendezvous.use_anchors=false ";

class RendezvousPlaces : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new test::TempFolder;
    first_ = new Outcome(
        test::virSlam("rendezvous --rawlog " + quoted("A=" + kSample + "A.rawlog") + " --rawlog " +
                      quoted("B=" + kSample + "B.rawlog") + " --out " + quoted(path("first"))));
  }
  static void TearDownTestSuite() {
    delete first_;
    delete folder_;
  }
  static std::string path(const std::string& name) { return (*folder_ / name).string(); }
  /// Of the finished runs.
  static Outcome meet(const std::string& out, const std::string& more) {
    return test::virSlam("rendezvous --rawlog " + quoted("A=" + path("first/A")) + " --rawlog " +
                         quoted("B=" + path("first/B")) + " --out " + quoted(path(out)) + " " +
                         more);
  }
  static Json jsonIn(const std::string& name) { return Json::parse(std::ifstream(path(name))); }
  static Json transformIn(const std::string& out) {
    return jsonIn(out + "/transforms.json")["transforms"][0];
  }
  static bool warns(const std::string& out, const std::string& text) {
    const Json warnings = jsonIn(out + "/summary.json")["warnings"];
    for (const Json& w : warnings) {
      if (contains(w.get<std::string>(), text)) return true;
    }
    return false;
  }

  static test::TempFolder* folder_;
  static Outcome* first_;
};
test::TempFolder* RendezvousPlaces::folder_ = nullptr;
Outcome* RendezvousPlaces::first_ = nullptr;

TEST_F(RendezvousPlaces, AreInTheVerdict) {
  ASSERT_EQ(first_->code, 0) << first_->text;
  EXPECT_TRUE(fs::exists(path("first/A/map.virmap")));
  const Json t = transformIn("first");
  EXPECT_EQ(t["status"], "unique");
  EXPECT_GE(t["places"].get<int>(), 2);
  EXPECT_EQ(t["places_used"], t["places"]);
  EXPECT_GT(t["ranges_used"].get<int>(), 200);
  EXPECT_TRUE(contains(first_->text, "places seen by both")) << first_->text;

  const Outcome without = meet("without", "--set Rendezvous.use_places=false");
  ASSERT_EQ(without.code, 0) << without.text;
  EXPECT_EQ(transformIn("without")["places"], 0);
  const Json with_error = jsonIn("first/summary.json")["merge_errors"][0];
  const Json error = jsonIn("without/summary.json")["merge_errors"][0];
  std::printf("merged %.3f m with places, %.3f m without\n",
              with_error["merged_rmse_m"].get<double>(), error["merged_rmse_m"].get<double>());
  EXPECT_LT(with_error["merged_rmse_m"].get<double>(), 0.12);
  EXPECT_LT(with_error["yaw_error_deg"].get<double>(), 1);
}

/// Finished runs whose maps are where used.ini says; no range, no anchor.
TEST_F(RendezvousPlaces, AreEnoughAlone) {
  ASSERT_EQ(first_->code, 0) << first_->text;
  const Outcome alone = meet("alone", kImagesAlone);
  ASSERT_EQ(alone.code, 0) << alone.text;
  const Json t = transformIn("alone");
  EXPECT_EQ(t["status"], "unique") << t;
  EXPECT_EQ(t["ranges_used"], 0);
  EXPECT_EQ(t["anchors_used"], 0);
  EXPECT_GE(t["places_used"].get<int>(), 2);
  EXPECT_TRUE(t["first_unique_s"].is_null());
  const Json error = jsonIn("alone/summary.json")["merge_errors"][0];
  std::printf("merged %.3f m, yaw off by %.2f deg, by images alone\n",
              error["merged_rmse_m"].get<double>(), error["yaw_error_deg"].get<double>());
  EXPECT_LT(error["merged_rmse_m"].get<double>(), 0.3) << error;
  EXPECT_LT(error["yaw_error_deg"].get<double>(), 3) << error;
  for (int k = 0; k < 4; ++k) {
    EXPECT_GT(t["covariance"][k][k].get<double>(), 0) << k;
    EXPECT_LT(t["covariance"][k][k].get<double>(), 0.64) << k;
  }

  const Outcome nothing = meet("nothing", kImagesAlone + "--set Rendezvous.use_places=false");
  EXPECT_EQ(nothing.code, 1) << nothing.text;
  EXPECT_EQ(transformIn("nothing")["status"], "degenerate");

  // The same input, the same bytes.
  ASSERT_EQ(meet("again", kImagesAlone).code, 0);
  EXPECT_EQ(test::readText(path("again/transforms.json")),
            test::readText(path("alone/transforms.json")));
}

TEST_F(RendezvousPlaces, MapsThatCannotBeUsedAreSaid) {
  ASSERT_EQ(first_->code, 0) << first_->text;
  std::string bytes = test::readText(path("first/A/map.virmap"));
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
  test::writeText(path("bad.virmap"), bytes);
  Outcome o = meet("bad", "--map " + quoted("A=" + path("bad.virmap")));
  EXPECT_EQ(o.code, 2) << o.text;
  EXPECT_TRUE(contains(o.text, "checksum")) << o.text;
  EXPECT_FALSE(fs::exists(path("bad")));
  o = meet("gone", "--map " + quoted("A=" + path("none.virmap")));
  EXPECT_EQ(o.code, 2) << o.text;
  EXPECT_TRUE(contains(o.text, "none.virmap")) << o.text;
  o = meet("who", "--map " + quoted("C=" + path("first/A/map.virmap")));
  EXPECT_EQ(o.code, 2) << o.text;
  EXPECT_TRUE(contains(o.text, "no robot C")) << o.text;
  o = meet("what", "--map " + quoted(path("first/A/map.virmap")));
  EXPECT_EQ(o.code, 2) << o.text;
  EXPECT_TRUE(contains(o.text, "NAME=FILE")) << o.text;
  o = test::virSlam("rendezvous --rawlog " + quoted("A=" + kSample + "A.rawlog") + " --rawlog " +
                    quoted("B=" + kSample + "B.rawlog") + " --out " + quoted(path("made")) +
                    " --map " + quoted("A=" + path("first/A/map.virmap")));
  EXPECT_EQ(o.code, 2) << o.text;
  EXPECT_TRUE(contains(o.text, "estimated here")) << o.text;

  // A map given beside the folder.
  o = meet("given", kImagesAlone + "--map " + quoted("A=" + path("first/A/map.virmap")));
  EXPECT_EQ(o.code, 0) << o.text;
  EXPECT_EQ(transformIn("given")["status"], "unique");

  // One that the run has left and that is damaged by now: the ranges go on without.
  fs::copy(path("first/A"), path("copy"), fs::copy_options::recursive);
  test::writeText(path("copy/map.virmap"), bytes);
  o = test::virSlam("rendezvous --rawlog " + quoted("A=" + path("copy")) + " --rawlog " +
                    quoted("B=" + path("first/B")) + " --out " + quoted(path("damaged")));
  EXPECT_EQ(o.code, 0) << o.text;
  EXPECT_EQ(transformIn("damaged")["places"], 0);
  EXPECT_TRUE(warns("damaged", "checksum"));
}

/// Descriptors alone do not tell places that look alike apart: no image, no loop.
TEST_F(RendezvousPlaces, AreNotLookedForWithoutImages) {
  ASSERT_EQ(first_->code, 0) << first_->text;
  fs::copy(kSample + "B.rawlog", path("blind_B.rawlog"));
  const Outcome o =
      meet("blind", kImagesAlone + "--ranges " + quoted("B=" + path("blind_B.rawlog")));
  EXPECT_EQ(o.code, 1) << o.text;
  EXPECT_EQ(transformIn("blind")["status"], "degenerate");
  EXPECT_TRUE(warns("blind", "no image in its recording"));
}

}  // namespace
}  // namespace vir
