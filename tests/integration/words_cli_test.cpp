/// What is said to somebody who does not know the commands yet, and what of his is left alone.
#include <gtest/gtest.h>

#include "vir_test_rawlog.h"
#include "vir_test_shell.h"
#include "vir_test_temp_folder.h"

namespace vir {
namespace {

namespace fs = std::filesystem;
using test::contains;
using test::Outcome;
using test::quoted;
using test::virSlam;

TEST(Words, OtherWaysToAskForHelpAndVersion) {
  const std::string version = virSlam("--version").text;
  EXPECT_TRUE(contains(version, "vir-slam ")) << version;
  for (const char* asked : {"-V", "version"}) {
    const Outcome outcome = virSlam(asked);
    EXPECT_EQ(outcome.code, 0);
    EXPECT_EQ(outcome.text, version);
  }
  const std::vector<std::pair<std::string, std::string>> same{
      {"help", "--help"},
      {"help run", "run --help"},
      {"help calibrate uwb", "calibrate uwb --help"}};
  for (const auto& [asked, known] : same) {
    const Outcome outcome = virSlam(asked);
    EXPECT_EQ(outcome.code, 0) << asked;
    EXPECT_EQ(outcome.text, virSlam(known).text) << asked;
  }
}

TEST(Words, SaysWhatWasMeant) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {"flight.rawlog --out x", "did you mean: vir-slam run flight.rawlog --out x\n"},
      {"'my flight.bag'", "did you mean: vir-slam run 'my flight.bag'\n"},
      {"--plugin-dir /x rum a.rawlog", "did you mean: vir-slam --plugin-dir /x run a.rawlog\n"},
      {"help evalute", "did you mean: vir-slam evaluate --help\n"},
      {"calibrate cammera a.rawlog", "did you mean: vir-slam calibrate camera a.rawlog\n"},
      {"frobnicate", "there is no command 'frobnicate'; there are: run, view, rendezvous, import"},
      {"run a.rawlog --rawlg b.rawlog", "did you mean --rawlog?"},
      {"import euroc --out x.rawlog", "'euroc' is a driver; name the recording as well"}};
  for (const auto& [words, answer] : cases) {
    const Outcome outcome = virSlam(words);
    EXPECT_EQ(outcome.code, 2) << words;
    EXPECT_TRUE(contains(outcome.text, answer)) << words << "\n" << outcome.text;
  }
}

TEST(Words, HelpOfADriverShowsItsSettings) {
  const Outcome outcome = virSlam("import euroc --help");
  EXPECT_EQ(outcome.code, 0) << outcome.text;
  EXPECT_TRUE(contains(outcome.text, "Usage: ")) << outcome.text;
  EXPECT_TRUE(contains(outcome.text, virSlam("plugins euroc").text)) << outcome.text;
  EXPECT_TRUE(contains(outcome.text, "max_duration_s = ")) << outcome.text;
  const Outcome unknown = virSlam("import nonsense --help");
  EXPECT_EQ(unknown.code, 0) << unknown.text;
  EXPECT_TRUE(contains(unknown.text, "No settings: ")) << unknown.text;
}

TEST(Words, KeysAreThoseOfTheSettings) {
  const Outcome keys = virSlam("plugins --keys");
  EXPECT_EQ(keys.code, 0) << keys.text;
  for (const char* line : {"estimator Estimator.use_ranges\n", "source euroc.max_duration_s\n",
                           "simulator simulator.tracks\n", "live Recording.stream_port\n"}) {
    EXPECT_TRUE(contains(keys.text, line)) << line;
  }
}

TEST(Words, BatchShowsAnExampleThatWorks) {
  const test::TempFolder folder;
  const std::string ini = (folder / "b.ini").string();
  test::writeText(ini, "[Batch]\nseeds = 1\n");
  const Outcome outcome = virSlam("batch " + quoted(ini));
  EXPECT_EQ(outcome.code, 2);
  const std::size_t at = outcome.text.find("  [Batch]");
  ASSERT_NE(at, std::string::npos) << outcome.text;
  test::writeText(ini, outcome.text.substr(at));
  test::writeText(folder / "euroc.ini", "[Estimator]\ndriver = auto\n");
  test::writeText(folder / "flight.rawlog", "");
  const Outcome listed = virSlam("batch " + quoted(ini) + " --list");
  EXPECT_EQ(listed.code, 0) << listed.text;
  EXPECT_EQ(listed.text, "flight/with_ranges\nflight/without\n");
}

class Overwriting : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return quoted((folder_ / name).string()); }
  void own(const std::string& name) { test::writeText(folder_ / name, "mine"); }
  void expectLeft(const std::string& name, const std::string& command) {
    const Outcome outcome = virSlam(command);
    EXPECT_EQ(outcome.code, 2) << command << "\n" << outcome.text;
    EXPECT_TRUE(contains(outcome.text, name)) << outcome.text;
    EXPECT_TRUE(contains(outcome.text, "--force")) << outcome.text;
    EXPECT_EQ(test::readText(folder_ / name), "mine") << command;
  }
  test::TempFolder folder_;
};

TEST_F(Overwriting, AFolderWithSomebodysFilesIsLeftAlone) {
  test::writeRecording((folder_ / "r.rawlog").string(), 5);
  own("work/summary.json");
  expectLeft("work/summary.json", "run " + path("r.rawlog") + " --out " + path("work"));
  own("copy/recording.rawlog");
  expectLeft("copy/recording.rawlog", "run " + path("r.rawlog") + " --out " + path("copy"));
}

TEST_F(Overwriting, TablesOfAnExportAreWrittenOverOurOwnOnly) {
  test::writeRecording((folder_ / "r.rawlog").string(), 5);
  own("tables/IMU0.csv");
  const std::string command =
      "export " + path("r.rawlog") + " --format csv --out " + path("tables");
  expectLeft("tables/IMU0.csv", command);
  EXPECT_EQ(virSlam(command + " --force").code, 0);
  EXPECT_EQ(virSlam(command).code, 0) << "what it left there itself";
}

TEST_F(Overwriting, AFileThatIsNotOursIsLeftAlone) {
  own("a.rawlog");
  own("calibration.yaml");
  own("truth.json");
  own("truth.svg");
  own("out.mcap");
  test::writeText(folder_ / "t.tum", "1 0 0 0 0 0 0 1\n2 1 0 0 0 0 0 1\n3 1 1 0 0 0 0 1\n");
  test::writeRecording((folder_ / "r.rawlog").string(), 5);
  expectLeft("a.rawlog", "simulate --out " + path("a.rawlog") + " --set simulator.tracks=true");
  expectLeft("calibration.yaml",
             "calibrate camera " + path("r.rawlog") + " --out " + path("calibration.yaml"));
  expectLeft("truth.json", "check " + path("r.rawlog") + " --json " + path("truth.json"));
  expectLeft("truth.svg", "evaluate --reference " + path("t.tum") + " " + path("t.tum") +
                              " --plot " + path("truth.svg"));
  expectLeft("out.mcap", "export " + path("r.rawlog") + " --format mcap --out " + path("out.mcap"));
  const std::string evaluate =
      "evaluate --reference " + path("t.tum") + " " + path("t.tum") + " --plot ";
  EXPECT_EQ(virSlam(evaluate + path("truth.svg") + " --force").code, 0);
  EXPECT_EQ(virSlam(evaluate + path("truth.svg")).code, 0) << "what it left there itself";
}

TEST_F(Overwriting, AFolderWithoutARunIsLeftAlone) {
  test::writeRecording((folder_ / "r.rawlog").string(), 5);
  fs::create_directory(folder_ / "rig");
  own("rig/calibration.yaml");
  own("rig/notes.txt");
  const std::string run = "run " + path("r.rawlog") + " --out " + path("rig");
  expectLeft("rig/calibration.yaml", run);
  fs::remove(folder_ / "rig/calibration.yaml");
  const int code = virSlam(run).code;
  EXPECT_EQ(code, 1) << "five images are no flight";
  EXPECT_EQ(test::readText(folder_ / "rig/notes.txt"), "mine");
  EXPECT_EQ(virSlam(run).code, code) << "a former run";
}

}  // namespace
}  // namespace vir
