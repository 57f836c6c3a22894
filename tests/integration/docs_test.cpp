/// What the documentation tells people to type is there: commands, options, settings, files, links.
#include <gtest/gtest.h>

#include <map>
#include <regex>
#include <set>

#include "vir_test_docs.h"
#include "vir_test_shell.h"
#include "vir_test_temp_folder.h"

namespace vir {
namespace {

namespace fs = std::filesystem;
using test::commandsIn;
using test::pages;
using test::wordsIn;

const fs::path kRoot = test::sourceRoot();

/// "calibrate camera": the words that name a command.
std::string nameOf(const std::vector<std::string>& words) {
  const bool two = words.size() > 1 && words[0] == "calibrate";
  return words.empty() ? "" : words[0] + (two ? " " + words[1] : "");
}

const std::string& helpOf(const std::string& command) {
  static std::map<std::string, std::string> known;
  const auto [at, fresh] = known.emplace(command, "");
  if (fresh) {
    const test::Outcome outcome = test::virSlam(command + " --help");
    at->second = outcome.code == 0 ? outcome.text + test::virSlam("--help").text : "";
  }
  return at->second;
}

/// Keys in lower case: sections are the same whatever their case.
std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

const std::set<std::string>& settings() {
  static const std::set<std::string> keys = [] {
    std::set<std::string> out;
    const std::string text = test::virSlam("plugins --keys").text;
    const std::regex line("[a-z]+ (\\S+)");
    for (std::sregex_iterator i(text.begin(), text.end(), line), end; i != end; ++i) {
      out.insert(lower((*i)[1]));
    }
    return out;
  }();
  return keys;
}

/// Sections that an ini may call as it likes, and words that stand for any key.
bool isFree(const std::string& section) {
  static const std::set<std::string> free{"section",       "batch",     "robot_a", "robot_b",
                                          "mine",          "cam0",      "imu0",    "uwb0",
                                          "replay_camera", "my_plugin", "table",   "replay_uwb"};
  return free.count(section) > 0;
}

void checkSetting(const std::string& word, const std::string& where) {
  static const std::regex setting("\"?([A-Za-z0-9_]+)\\.([a-z0-9_]+)=.*");
  std::smatch m;
  if (!std::regex_match(word, m, setting) || isFree(lower(m[1]))) return;
  EXPECT_EQ(settings().count(lower(m[1].str() + "." + m[2].str())), 1u)
      << where << ": there is no setting " << word;
}

void checkCommand(const std::string& command, const std::string& where) {
  // What is handed on to another program is not ours.
  static const std::regex handed_on("(--slurm-options) *\"[^\"]*\"");
  const std::vector<std::string> words =
      wordsIn(std::regex_replace(command, handed_on, "$1 OPTIONS"));
  const std::string name = nameOf(words);
  if (!std::regex_match(name, std::regex("[a-z]+( [a-z]+)?")) || name == "help" ||
      name == "version") {
    return;
  }
  const std::string& help = helpOf(name);
  ASSERT_FALSE(help.empty()) << where << ": there is no command " << name;
  for (std::size_t i = 1; i < words.size(); ++i) {
    std::smatch m;
    static const std::regex option("(--[a-z][a-z-]*)(=.*)?[.,;:)]*");
    if (std::regex_match(words[i], m, option)) {
      EXPECT_TRUE(std::regex_search(help, std::regex(m[1].str() + "[ ,:\n]")))
          << where << ": " << name << " has no " << m[1];
    } else if (std::regex_match(words[i], std::regex("ini/[a-z_]+\\.ini"))) {
      EXPECT_TRUE(fs::exists(kRoot / words[i])) << where << ": " << words[i];
    } else if (words[i - 1] == "--set") {
      checkSetting(words[i], where);
    }
  }
}

TEST(Docs, CommandsAreThere) {
  long seen = 0;
  for (const fs::path& page : pages()) {
    for (const std::string& command : commandsIn(test::readText(page))) {
      checkCommand(command, page.filename().string() + ": vir-slam " + command);
      ++seen;
    }
  }
  EXPECT_GT(seen, 100) << "the pattern finds what it should";
}

TEST(Docs, TheCheckFindsWhatIsWrong) {
  EXPECT_EQ(
      commandsIn(
          "vir-slam reads `vir-slam run\n a --out b` and\n\n    build/bin/vir-slam check c \\\n"
          "    --json d  # e\n```\n(cd x && vir-slam batch y)\nvir-slam plugins\n```\n"),
      (std::vector<std::string>{"check c      --json d ", "plugins", "run  a --out b"}));
  EXPECT_EQ(settings().count("imu.no_such_key"), 0u);
  EXPECT_EQ(settings().count("imu.gyro_noise_density"), 1u);
  EXPECT_EQ(helpOf("frobnicate"), "");
}

/// Settings in tables and sentences: `Window.readout_s` and the like.
TEST(Docs, SettingsThatMatterAreThere) {
  const std::string text = test::readText(kRoot / "docs/settings.md");
  const std::regex key("`([A-Z][A-Za-z]+\\.[a-z_0-9]+)`");
  long seen = 0;
  for (std::sregex_iterator i(text.begin(), text.end(), key), end; i != end; ++i, ++seen) {
    EXPECT_EQ(settings().count(lower((*i)[1])), 1u) << (*i)[1];
  }
  EXPECT_GE(seen, 10);
}

TEST(Docs, LinksLeadSomewhere) {
  for (const fs::path& page : pages()) {
    const std::string text = test::readText(page);
    const std::regex link("\\]\\(([^)#:]+)(#[^)]*)?\\)");
    for (std::sregex_iterator i(text.begin(), text.end(), link), end; i != end; ++i) {
      const std::string target = (*i)[1];
      if (target.find("://") != std::string::npos || target.find(' ') != std::string::npos)
        continue;
      EXPECT_TRUE(fs::exists(page.parent_path() / target)) << page.filename() << ": " << target;
    }
  }
}

}  // namespace
}  // namespace vir
