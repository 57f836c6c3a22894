/// A library includes headers of its own and of lower rungs only. The rungs are the "rung N:" lines
/// of libs/CMakeLists.txt.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "vir_test_paths.h"

namespace {

namespace fs = std::filesystem;

const fs::path kLibs = fs::path(vir::test::sourceDir()) / "libs";

std::map<std::string, int> readRungs() {
  std::map<std::string, int> rungs;
  std::ifstream in(kLibs / "CMakeLists.txt");
  const std::regex pattern("# rung ([0-9]+): (.*)");
  std::smatch match;
  for (std::string line; std::getline(in, line);) {
    if (!std::regex_match(line, match, pattern)) continue;
    std::istringstream names(match[2]);
    for (std::string name; names >> name;) rungs[name] = std::stoi(match[1]);
  }
  return rungs;
}

bool isSource(const fs::path& file) {
  const std::string extension = file.extension().string();
  return extension == ".h" || extension == ".cpp";
}

/// Calls visit(library, file, header) for every include line of libs.
template <typename Visit>
void forEachInclude(Visit visit) {
  const std::regex pattern("\\s*#\\s*include\\s*[<\"]([^>\"]+)[>\"].*");
  std::smatch match;
  for (const auto& item : fs::recursive_directory_iterator(kLibs)) {
    if (!item.is_regular_file() || !isSource(item.path())) continue;
    const std::string library = fs::relative(item.path(), kLibs).begin()->string();
    std::ifstream in(item.path());
    for (std::string line; std::getline(in, line);) {
      if (std::regex_match(line, match, pattern)) visit(library, item.path(), match[1].str());
    }
  }
}

TEST(Ladder, EveryLibraryHasARung) {
  const auto rungs = readRungs();
  ASSERT_FALSE(rungs.empty());
  for (const auto& item : fs::directory_iterator(kLibs)) {
    if (!item.is_directory()) continue;
    EXPECT_EQ(rungs.count(item.path().filename().string()), 1u)
        << item.path() << " has no rung in libs/CMakeLists.txt";
  }
}

TEST(Ladder, IncludesOnlyGoDown) {
  const auto rungs = readRungs();
  const std::regex ours("vir/([a-z_]+)/.*");
  int checked = 0;
  forEachInclude([&](const std::string& library, const fs::path& file, const std::string& header) {
    std::smatch match;
    if (!std::regex_match(header, match, ours)) return;
    const std::string used = match[1];
    ++checked;
    ASSERT_EQ(rungs.count(used), 1u) << file << " includes " << header;
    EXPECT_TRUE(used == library || rungs.at(used) < rungs.at(library))
        << file << " (rung " << rungs.at(library) << ") includes " << header << " (rung "
        << rungs.at(used) << ")";
  });
  EXPECT_GT(checked, 20);  // the pattern still finds something
}

TEST(Ladder, OnlyTheUpperRungsKnowMrptBeyondItsSettings) {
  const auto rungs = readRungs();
  forEachInclude([&](const std::string& library, const fs::path& file, const std::string& header) {
    if (header.rfind("mrpt/", 0) != 0 || rungs.at(library) >= rungs.at("rawlog")) return;
    EXPECT_TRUE(library == "core" && header.rfind("mrpt/config/", 0) == 0)
        << file << " includes " << header;
  });
}

/// The text of every source below `folders` of the project.
template <typename Visit>
void forEachSource(const std::vector<std::string>& folders, Visit visit) {
  for (const std::string& folder : folders) {
    for (const auto& item :
         fs::recursive_directory_iterator(fs::path(vir::test::sourceDir()) / folder)) {
      if (!item.is_regular_file() || !isSource(item.path())) continue;
      std::ifstream in(item.path());
      std::ostringstream text;
      text << in.rdbuf();
      visit(item.path(), text.str());
    }
  }
}

TEST(Ladder, EveryPublicHeaderIsInTheNamespaceOfItsLibrary) {
  int checked = 0;
  forEachSource({"libs"}, [&](const fs::path& file, const std::string& text) {
    if (file.string().find("/include/vir/") == std::string::npos) return;
    const std::string library = file.parent_path().filename().string();
    ++checked;
    // The vocabulary may be spoken without its library's name: geometry::Pose is vir::Pose.
    const bool named = text.find("namespace vir::" + library) != std::string::npos ||
                       text.find("inline namespace " + library + " {") != std::string::npos;
    EXPECT_TRUE(named) << file;
  });
  EXPECT_GT(checked, 80);
}

TEST(Ladder, TestsAreInFilesNamedAfterWhatTheyTest) {
  const std::regex test("\\n(TEST|TEST_F|TEST_P|TYPED_TEST)\\(");
  int checked = 0;
  forEachSource({"tests"}, [&](const fs::path& file, const std::string& text) {
    if (!std::regex_search(text, test)) return;
    ++checked;
    const std::string name = file.filename().string();
    EXPECT_TRUE(std::regex_match(name, std::regex("[a-z0-9_]+_test\\.cpp")) &&
                name.rfind("test_", 0) != 0)
        << file << ": a file of tests is called SUBJECT_test.cpp";
  });
  EXPECT_GT(checked, 140);
}

TEST(Ladder, LabelsOfARecordingAreSpelledInOnePlace) {
  const std::regex label("\"(CAM0|TRACKS0|IMU0|UWB0|ODOM|GT|PEER:?|ANCHOR:)\"");
  forEachSource({"libs", "plugins", "apps"}, [&](const fs::path& file, const std::string& text) {
    if (file.stem() == "labels") return;
    EXPECT_FALSE(std::regex_search(text, label)) << file << ": use vir/rawlog/labels.h";
  });
}

/// A subcommand says what it takes and wires; what it does is elsewhere.
TEST(Ladder, ASubcommandHasAtMost150Lines) {
  int checked = 0;
  forEachSource({"apps/vir-slam/commands"}, [&](const fs::path& file, const std::string& text) {
    ++checked;
    EXPECT_LE(std::count(text.begin(), text.end(), '\n'), 150) << file;
  });
  EXPECT_GT(checked, 10);
}

TEST(Ladder, AFileHasAtMost400Lines) {
  forEachSource({"libs", "plugins", "apps", "tests"},
                [](const fs::path& file, const std::string& text) {
                  EXPECT_LE(std::count(text.begin(), text.end(), '\n'), 400) << file;
                });
}

TEST(Ladder, TestsCompareExitCodesExactly) {
  // "Not 0" is true of a crash as well.
  const std::regex loose("code\\s*!=\\s*0|(EXPECT|ASSERT)_NE\\([^,;]*[cC]ode, *0\\)");
  forEachSource({"tests"}, [&](const fs::path& file, const std::string& text) {
    if (file.stem() == "ladder_test") return;
    EXPECT_FALSE(std::regex_search(text, loose)) << file;
  });
}

}  // namespace
