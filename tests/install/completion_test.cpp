/// Completion and man pages are what --help says.
#include <gtest/gtest.h>

#include <regex>
#include <set>
#include <sstream>

#include "install_tree.h"

namespace vir {
namespace {

namespace fs = std::filesystem;
using test::Outcome;
using test::quoted;
using Words = std::set<std::string>;

Words words(const std::string& text) {
  std::istringstream in(text);
  Words out;
  for (std::string word; in >> word;) out.insert(word);
  return out;
}

/// What bash offers for the last of `line`'s words, which are separated by blanks; "" is a word.
Words complete(const std::vector<std::string>& line) {
  const fs::path file = test::installTree() / "share/bash-completion/completions/vir-slam";
  std::string call = "source " + quoted(file.string()) + "; COMP_WORDS=(vir-slam";
  for (const std::string& word : line) call += " \"" + word + "\"";
  call += "); COMP_CWORD=" + std::to_string(line.size()) +
          "; _vir_slam && printf '%s\\n' \"${COMPREPLY[@]}\"";
  const Outcome outcome = test::shell("bash -euo pipefail -c '" +
                                      std::regex_replace(call, std::regex("'"), "'\\''") + "'");
  EXPECT_EQ(outcome.code, 0) << outcome.text;
  return words(outcome.text);
}

std::string help(const std::string& subcommand) {
  const Outcome outcome = test::installedVirSlam(subcommand + " --help");
  EXPECT_EQ(outcome.code, 0) << outcome.text;
  return outcome.text;
}

Words subcommands() {
  const std::string text = help("");
  Words out;
  const std::regex line("\n  ([a-z][a-z-]*) ");
  const std::string list = text.substr(text.find("Subcommands:"));
  for (std::sregex_iterator i(list.begin(), list.end(), line), end; i != end; ++i) {
    out.insert((*i)[1]);
  }
  return out;
}

TEST(Completion, OffersEverySubcommand) {
  EXPECT_EQ(complete({""}), subcommands());
  EXPECT_EQ(complete({"eval"}), Words{"evaluate"});
  EXPECT_EQ(complete({"--plugin-dir", "/x", "eval"}), Words{"evaluate"});
}

TEST(Completion, OffersEveryOption) {
  const Words all = subcommands();
  ASSERT_GE(all.size(), 8u);
  for (const std::string& subcommand : all) {
    const std::string text = help(subcommand);
    const Words offered = complete({subcommand, "--"});
    EXPECT_EQ(offered.count("--help"), 1u) << subcommand;
    EXPECT_EQ(offered.count("--plugin-dir"), 1u) << subcommand;
    const std::regex option("\n  (?:-[a-z],)?(--[a-z-]+)");
    for (std::sregex_iterator i(text.begin(), text.end(), option), end; i != end; ++i) {
      EXPECT_EQ(offered.count((*i)[1]), 1u) << subcommand << " " << (*i)[1];
    }
  }
  EXPECT_EQ(complete({"run", "x.ini", "--raw"}), Words{"--rawlog"});
}

TEST(Completion, OffersValuesAndNestedSubcommands) {
  EXPECT_EQ(complete({"evaluate", "--align", ""}), (Words{"posyaw", "se3", "sim3", "none"}));
  EXPECT_EQ(complete({"evaluate", "--align", "=", "s"}), (Words{"se3", "sim3"}));
  EXPECT_EQ(complete({"calibrate", "u"}), Words{"uwb"});
  // Files: bash offers them by itself where nothing else is.
  EXPECT_EQ(complete({"run", "--rawlog", ""}), Words{});
}

TEST(Completion, OffersSettingsOfTheSubcommand) {
  EXPECT_EQ(complete({"run", "a.rawlog", "--set", "Estimator.use_ra"}),
            Words{"Estimator.use_ranges="});
  EXPECT_EQ(complete({"run", "a.rawlog", "--set", "=", "Imu.gyro_noise"}),
            Words{"Imu.gyro_noise_density="});
  EXPECT_EQ(complete({"import", "--set", "euroc.max_dur"}), Words{"euroc.max_duration_s="});
  EXPECT_EQ(complete({"simulate", "--set", "simulator.tr"}), Words{"simulator.tracks="});
  EXPECT_EQ(complete({"simulate", "--set", "euroc.max_dur"}), Words{});
}

TEST(ManPages, OneForEachSubcommand) {
  const fs::path man = test::installTree() / "share/man/man1";
  for (const std::string& subcommand : subcommands()) {
    const fs::path page = man / ("vir-slam-" + subcommand + ".1.gz");
    const Outcome text = test::shell("gzip -dc " + quoted(page.string()));
    ASSERT_EQ(text.code, 0) << text.text;
    for (const char* part : {".TH", ".SH NAME", ".SH SYNOPSIS", ".SH OPTIONS", "\\-\\-help"}) {
      EXPECT_TRUE(test::contains(text.text, part)) << page << " lacks " << part;
    }
  }
  const Outcome root = test::shell("gzip -dc " + quoted((man / "vir-slam.1.gz").string()));
  EXPECT_TRUE(test::contains(root.text, "vir\\-slam\\-run(1)")) << root.text;
}

}  // namespace
}  // namespace vir
