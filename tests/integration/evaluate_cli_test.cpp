/// `vir-slam evaluate` as a user calls it: exit codes, table, JSON, plots.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "vir_test_paths.h"
#include "vir_test_shell.h"

namespace {

namespace fs = std::filesystem;

using vir::test::Outcome;

class EvaluateCli : public testing::Test {
 protected:
  void SetUp() override {
    // A folder with a blank, one per test: ctest runs them side by side.
    const std::string name = testing::UnitTest::GetInstance()->current_test_info()->name();
    folder_ = fs::path(vir::test::buildDir()) / ("evaluate cli " + name);
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    write("ref.tum", line(200, 0.0));
    write("est.tum", line(180, 0.1));
  }
  void TearDown() override { fs::remove_all(folder_); }

  /// Along a curve, 20 Hz; `dz` puts a wave on the height.
  static std::string line(int n, double dz) {
    std::ostringstream out;
    for (int i = 0; i < n; ++i) {
      const double t = 0.05 * i;
      out << std::fixed << 1000 + t << " " << t << " " << std::sin(t) << " " << dz * std::sin(3 * t)
          << " 0 0 0 1\n";
    }
    return out.str();
  }

  void write(const std::string& name, const std::string& text) {
    std::ofstream(folder_ / name) << text;
  }

  std::string path(const std::string& name) const { return "'" + (folder_ / name).string() + "'"; }

  std::string content(const std::string& name) const {
    std::ifstream in(folder_ / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }

  static Outcome call(const std::string& arguments) {
    return vir::test::virSlam("evaluate " + arguments);
  }

  fs::path folder_;
};

TEST_F(EvaluateCli, SaysWhatSeemsToBeWrong) {
  std::istringstream in(line(200, 0.0));
  std::string in_mm;
  for (std::string row; std::getline(in, row);) {
    double t = 0, x = 0, y = 0, z = 0;
    ASSERT_EQ(std::sscanf(row.c_str(), "%lf %lf %lf %lf", &t, &x, &y, &z), 4);
    char text[160];
    std::snprintf(text, sizeof text, "%.6f %.6f %.6f %.6f 0 0 0 1\n", t, 1000 * x, 1000 * y,
                  1000 * z);
    in_mm += text;
  }
  write("mm.tum", in_mm);
  const Outcome outcome = vir::test::virSlam(
      "evaluate --reference '" + (folder_ / "mm.tum").string() + "' '" +
      (folder_ / "est.tum").string() + "' --json '" + (folder_ / "e.json").string() + "'");
  EXPECT_EQ(outcome.code, 0) << outcome.text;
  EXPECT_NE(outcome.text.find("the positions of the reference seem to be in mm"), std::string::npos)
      << outcome.text;
  std::ifstream json(folder_ / "e.json");
  EXPECT_EQ(nlohmann::json::parse(json)["estimates"][0]["hints"].size(), 1u);
}

TEST_F(EvaluateCli, TableJsonAndPlots) {
  const std::string both = "--reference " + path("ref.tum") + " " + path("est.tum") + " " +
                           path("ref.tum") + " --json " + path("o.json");
  const Outcome svg = call(both + " --plot " + path("o.svg"));
  EXPECT_EQ(svg.code, 0) << svg.text;
  EXPECT_NE(svg.text.find("aligned in position and yaw"), std::string::npos) << svg.text;
  EXPECT_NE(svg.text.find("ATE position rmse [m]"), std::string::npos) << svg.text;
  EXPECT_EQ(call(both + " --plot " + path("o.png")).code, 0);

  const auto json = nlohmann::json::parse(content("o.json"));
  ASSERT_EQ(json["estimates"].size(), 2u);
  const auto& e = json["estimates"][0];
  // The mean of the wave is taken off by the alignment, its rmse is 0.1 / sqrt(2) over periods.
  EXPECT_NEAR(e["ate_position_m"]["rmse"].get<double>(), 0.0707, 0.003);
  EXPECT_EQ(e["matched"], 180);
  EXPECT_NEAR(e["coverage"].get<double>(), 8.95 / 9.95, 1e-9);
  EXPECT_EQ(json["comparison"]["alignment"], "posyaw");
  EXPECT_LT(json["estimates"][1]["ate_position_m"]["max"].get<double>(), 1e-9);
  EXPECT_NE(content("o.svg").find("</svg>"), std::string::npos);
  EXPECT_EQ(content("o.png").compare(1, 3, "PNG"), 0);
}

/// Words for what is no number, and numbers that no double holds: the line is left out and said.
TEST_F(EvaluateCli, InfiniteNumbersAreLeftOutAndSaid) {
  for (const char* word : {"inf", "-inf", "nan", "1e400", "INFINITY"}) {
    std::string text = line(180, 0.1);
    const std::size_t third = text.find('\n', text.find('\n') + 1) + 1;
    const std::size_t x = text.find(' ', third) + 1;
    text.replace(x, text.find(' ', x) - x, word);
    write("bad.tum", text);
    const Outcome o = call("--reference " + path("ref.tum") + " " + path("bad.tum") + " --json " +
                           path("o.json"));
    EXPECT_EQ(o.code, 0) << word << o.text;
    EXPECT_NE(o.text.find("1 lines skipped"), std::string::npos) << word << o.text;
    const auto json = nlohmann::json::parse(content("o.json"));
    EXPECT_EQ(json["estimates"][0]["matched"], 179) << word;
    EXPECT_LT(json["estimates"][0]["ate_position_m"]["max"].get<double>(), 0.5) << word;
  }
}

TEST_F(EvaluateCli, SeveralReferences) {
  const Outcome o = call("--reference " + path("ref.tum") + " --reference " + path("est.tum") +
                         " " + path("est.tum") + " --json " + path("o.json"));
  EXPECT_EQ(o.code, 0) << o.text;
  EXPECT_NE(o.text.find("ref.tum\n"), std::string::npos) << o.text;
  EXPECT_NE(o.text.find("est.tum\n"), std::string::npos) << o.text;
  const auto json = nlohmann::json::parse(content("o.json"));
  ASSERT_EQ(json["references"].size(), 2u);
  const auto rmse = [&](int i) {
    return json["references"][i]["estimates"][0]["ate_position_m"]["rmse"].get<double>();
  };
  EXPECT_NEAR(rmse(0), 0.0707, 0.003);
  EXPECT_LT(rmse(1), 1e-9);
}

/// Attitudes that are not in a file have no errors.
TEST_F(EvaluateCli, AnEstimateOfPositionsAlone) {
  std::istringstream in(line(180, 0.0));
  std::string text;
  for (std::string l; std::getline(in, l);) text += l.substr(0, l.find(" 0 0 0 1")) + "\n";
  write("positions.txt", text);
  const Outcome o = call("--reference " + path("ref.tum") + " " + path("positions.txt"));
  EXPECT_EQ(o.code, 0) << o.text;
  EXPECT_NE(o.text.find("the estimate has positions only"), std::string::npos) << o.text;
}

TEST_F(EvaluateCli, ImagesCovered) {
  write("data.csv", "#timestamp [ns],filename\r\n999000000000,a.png\r\n1001000000000,b.png\r\n");
  const Outcome o = call("--reference " + path("ref.tum") + " " + path("est.tum") + " --images " +
                         path("data.csv"));
  EXPECT_EQ(o.code, 0);
  EXPECT_NE(o.text.find("1 of 2"), std::string::npos) << o.text;
}

TEST_F(EvaluateCli, OneBadEstimateDoesNotHideTheOthers) {
  write("empty.tum", "");
  write("late.tum", "5 0 0 0 0 0 0 1\nrubbish\n");
  const Outcome o = call("--reference " + path("ref.tum") + " " + path("empty.tum") + " " +
                         path("late.tum") + " " + path("est.tum") + " --json " + path("o.json"));
  EXPECT_EQ(o.code, 1);
  EXPECT_NE(o.text.find("empty.tum: is empty"), std::string::npos) << o.text;
  EXPECT_NE(o.text.find("the estimate holds no pose"), std::string::npos) << o.text;
  EXPECT_NE(o.text.find("0 of 1 poses"), std::string::npos) << o.text;
  EXPECT_NE(o.text.find("line 2"), std::string::npos) << o.text;
  const auto json = nlohmann::json::parse(content("o.json"));
  EXPECT_TRUE(json["estimates"][2]["error"].is_null());
  EXPECT_TRUE(json["estimates"][0]["error"].is_string());
}

TEST_F(EvaluateCli, TheFolderOfARunIsItsTrajectoryAndARawlogIsNone) {
  fs::create_directories(folder_ / "run");
  write("run/trajectory.tum", line(180, 0.1));
  const std::string reference = "--reference " + path("ref.tum") + " ";
  const Outcome file = call(reference + path("est.tum")), folder = call(reference + path("run"));
  EXPECT_EQ(folder.code, 0) << folder.text;
  const auto ate = [](const std::string& text) {
    const std::size_t at = text.find("ATE");
    return text.substr(at, text.find('\n', at) - at);
  };
  EXPECT_EQ(ate(folder.text), ate(file.text));
  write("x.rawlog", std::string("\x1F\x8B\x08\0\x01\x02", 6));
  const Outcome rawlog = call("--reference " + path("x.rawlog") + " " + path("est.tum"));
  EXPECT_EQ(rawlog.code, 2);
  EXPECT_TRUE(vir::test::contains(rawlog.text, "export FILE.rawlog --format tum")) << rawlog.text;
}

TEST_F(EvaluateCli, WrongUseIsCodeTwo) {
  const std::string good = "--reference " + path("ref.tum") + " " + path("est.tum");
  EXPECT_EQ(call("").code, 2);
  EXPECT_EQ(call("--reference " + path("ref.tum")).code, 2);
  EXPECT_EQ(call(good + " --align rigid").code, 2);
  EXPECT_EQ(call(good + " --max-gap-s nan").code, 2);
  EXPECT_EQ(call(good + " --nonsense").code, 2);
  EXPECT_EQ(call("--reference " + path("none.tum") + " " + path("est.tum")).code, 2);
  const Outcome folder = call("--reference " + path("ref.tum") + " " + path("."));
  EXPECT_EQ(folder.code, 2);
  EXPECT_NE(folder.text.find("folder"), std::string::npos) << folder.text;
}

TEST_F(EvaluateCli, APlotInAnotherFormatIsRefused) {
  for (const char* file : {"o.pdf", "o", "o.svgz", ".png"}) {
    const Outcome o =
        call("--reference " + path("ref.tum") + " " + path("est.tum") + " --plot " + path(file));
    EXPECT_EQ(o.code, 2) << file;
    EXPECT_NE(o.text.find(".svg or .png"), std::string::npos) << o.text;
  }
}

TEST_F(EvaluateCli, AFileThatCannotBeWrittenIsCodeOne) {
  const std::string good = "--reference " + path("ref.tum") + " " + path("est.tum");
  for (const char* option : {"--json", "--plot"}) {
    for (const char* file : {"no/such/x.svg", "no/such/x.png"}) {
      const Outcome o = call(good + " " + option + " " + path(file));
      EXPECT_EQ(o.code, 1) << option << file;
      EXPECT_NE(o.text.find("cannot write"), std::string::npos) << o.text;
    }
  }
}

TEST_F(EvaluateCli, Help) {
  const Outcome o = call("--help");
  EXPECT_EQ(o.code, 0);
  EXPECT_NE(o.text.find("Examples:"), std::string::npos);
}

}  // namespace
