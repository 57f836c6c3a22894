/// vir-slam simulate as a user calls it.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "vir_test_shell.h"
#include "vir_test_temp_folder.h"

namespace vir {
namespace {

namespace fs = std::filesystem;
using test::quoted;

class SimulateCli : public ::testing::Test {
 protected:
  void SetUp() override {
    std::ofstream((folder / "world.ini").string())
        << "[simulator]\nrobots = A B\n"
           "[Robot_A]\nduration_s = 4\n[Robot_B]\nduration_s = 4\nstart_m = 1 2 0\n"
           "[Camera]\nwidth_px = 96\nheight_px = 64\nfx_px = 60\nfy_px = 60\ncx_px = 48\n"
           "cy_px = 32\n[SimulatedRanges]\nanchor_m = 2 2 1\n";
  }
  test::Outcome simulate(const std::string& name, const std::string& more = "") {
    return test::virSlam("simulate " + quoted((folder / "world.ini").string()) + " --out " +
                         quoted((folder / name).string()) + " " + more);
  }
  std::string bytes(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  }
  test::TempFolder folder;
};

TEST_F(SimulateCli, WritesOneRawlogPerRobotWithAllThatBelongsToIt) {
  const test::Outcome outcome = simulate("w.rawlog");
  ASSERT_EQ(outcome.code, 0) << outcome.text;
  for (const char* name : {"w_A", "w_B"}) {
    const std::string stem = (folder / name).string();
    EXPECT_TRUE(fs::exists(stem + ".rawlog"));
    EXPECT_TRUE(fs::exists(stem + ".ini"));
    EXPECT_NE(bytes(stem + "_anchors_truth.csv").find("0,2,2,1"), std::string::npos);
    long images = 0;
    for (const auto& image : fs::directory_iterator(stem + "_Images")) {
      images += image.path().extension() == ".jpg" ? 1 : 0;
    }
    EXPECT_EQ(images, 80);
  }
  EXPECT_FALSE(fs::exists(folder / "w.rawlog"));
}

TEST_F(SimulateCli, SameSeedSameBytes) {
  ASSERT_EQ(simulate("a.rawlog").code, 0);
  ASSERT_EQ(simulate("b.rawlog").code, 0);
  ASSERT_EQ(simulate("c.rawlog", "--set simulator.seed=1").code, 0);
  const std::string a = bytes(folder / "a_B.rawlog");
  EXPECT_GT(a.size(), 10000u);
  EXPECT_EQ(a, bytes(folder / "b_B.rawlog"));
  EXPECT_NE(a, bytes(folder / "c_B.rawlog"));
  long compared = 0;
  for (const auto& image : fs::directory_iterator(folder / "a_A_Images")) {
    const std::string pixels = bytes(image.path());
    EXPECT_EQ(pixels, bytes(folder / "b_A_Images" / image.path().filename()));
    EXPECT_NE(pixels, bytes(folder / "c_A_Images" / image.path().filename()));
    ++compared;
  }
  EXPECT_EQ(compared, 80);
}

TEST_F(SimulateCli, OneRobotIsCalledAsSaid) {
  const test::Outcome outcome =
      simulate("b.rawlog", "--set simulator.robot=B --set simulator.tracks=true");
  ASSERT_EQ(outcome.code, 0) << outcome.text;
  EXPECT_TRUE(fs::exists(folder / "b.rawlog"));
  EXPECT_FALSE(fs::exists(folder / "b_B.rawlog"));
  EXPECT_FALSE(fs::exists(folder / "b_Images"));
  EXPECT_TRUE(test::contains(outcome.text, "TRACKS0"));
}

TEST_F(SimulateCli, SaysWhatIsWrong) {
  const auto refused = [&](const std::string& more, const std::string& word) {
    const test::Outcome o = simulate("x.rawlog", more);
    EXPECT_EQ(o.code, 2) << o.text;
    EXPECT_TRUE(test::contains(o.text, word)) << o.text;
    EXPECT_FALSE(fs::exists(folder / "x_A.rawlog"));
  };
  refused("--set simulator.robots=AB", "robots");
  refused("--set simulator.robot=C", "robot");
  refused("--set Robot_C.flight=eight", "Robot_C");
  refused("--set Robot_A.flight=teapot", "flight");
  refused("--set Scene.layout=castle", "layout");
  const test::Outcome o = test::virSlam("simulate nowhere.ini --out x.rawlog");
  EXPECT_EQ(o.code, 2) << o.text;
}

}  // namespace
}  // namespace vir
