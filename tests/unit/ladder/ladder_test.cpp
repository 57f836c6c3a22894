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

std::string withoutComments(const std::string& text) {
  std::istringstream in(text);
  std::string out;
  for (std::string line; std::getline(in, line);) out += line.substr(0, line.find("//")) + "\n";
  return out;
}

/// A literal that is a label, of any number of its kind, or that one begins with. "IMU" alone is a
/// word for people.
const std::regex kLabel(
    "\"((CAM|TRACKS|UWB)[0-9]*|IMU[0-9]+|ODOM|GT|PEER|ANCHOR|(PEER|ANCHOR):[^\"\n]*)\"");

TEST(Ladder, FindsLabelsOfARecording) {
  for (const char* label :
       {"CAM0", "CAM1", "CAM", "TRACKS0", "IMU0", "IMU2", "UWB0", "UWB1", "UWB", "ODOM", "GT",
        "PEER", "PEER:", "PEER:1", "PEER:1:ANCHOR:2", "ANCHOR:", "ANCHOR:7"}) {
    EXPECT_TRUE(std::regex_search("f(\"" + std::string(label) + "\");", kLabel)) << label;
  }
  for (const char* other : {"IMU", "UWB_ID2", "ODOMETRY", "IMU.Frequency", "CAMERA", "cam0"}) {
    EXPECT_FALSE(std::regex_search("f(\"" + std::string(other) + "\");", kLabel)) << other;
  }
}

TEST(Ladder, LabelsOfARecordingAreSpelledInOnePlace) {
  forEachSource({"libs", "plugins", "apps"}, [](const fs::path& file, const std::string& text) {
    if (file.stem() == "labels") return;
    std::smatch found;
    const std::string code = withoutComments(text);
    EXPECT_FALSE(std::regex_search(code, found, kLabel))
        << file << ": " << found[0] << "; use vir/rawlog/labels.h";
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

/// MRPT's exceptions come with a headline and a stack trace, which are nobody's reason.
TEST(Ladder, WhatMrptSaysIsCleanedBeforeItIsShown) {
  const std::regex caught("catch \\(const std::exception& (\\w+)\\) \\{([^}]*)\\}");
  int checked = 0;
  forEachSource({"plugins", "apps/vir-slam", "libs/roles", "libs/runs", "libs/live"},
                [&](const fs::path& file, const std::string& text) {
                  const std::string code = withoutComments(text);
                  for (std::sregex_iterator i(code.begin(), code.end(), caught), end; i != end;
                       ++i) {
                    ++checked;
                    EXPECT_EQ(i->str(2).find(i->str(1) + ".what()"), std::string::npos)
                        << file << ": " << i->str() << "; use vir/rawlog/mrpt_error.h";
                  }
                });
  EXPECT_GT(checked, 10);
}

/// An exit code, by its usual names, in an assertion that is not EXPECT_EQ, or beside a number with
/// anything but == between them.
std::regex looseExitCode() {
  const std::string code = "(\\b(exit_)?code|[eE]xitCode|\\bwait\\(\\))";
  const std::string other = "(!=|<=?|>=?)";
  return std::regex("(EXPECT|ASSERT)_(NE|GT|GE|LT|LE|TRUE|FALSE)\\([^;<]*" + code +
                    "\\s*[=!<>,|&)]|" + code + "\\s*" + other + "\\s*-?[0-9]|[0-9]\\s*" + other +
                    "\\s*[\\w.]*" + code);
}

TEST(Ladder, FindsLooseComparisonsOfExitCodes) {
  const std::regex loose = looseExitCode();
  for (const char* text :
       {"EXPECT_NE(run.code, 0);", "EXPECT_NE(0, run.code) << run.text;", "ASSERT_NE(code, 0);",
        "EXPECT_GT(run(x).code, 0);", "ASSERT_LT(0, code);", "EXPECT_TRUE(code == 1 || code == 2);",
        "EXPECT_FALSE(run.code);", "EXPECT_NE(p.wait(), 0);", "EXPECT_GT(\n    first.wait(), 0);",
        "if (run.code != 0) return;", "ok = p.wait() > 0;", "ok = 0 != run.code;"}) {
    EXPECT_TRUE(std::regex_search(text, loose)) << text;
  }
  for (const char* text : {"EXPECT_EQ(run.code, 2) << run.text;", "EXPECT_EQ(1, p.wait());",
                           "ok = run.code == 0;", "EXPECT_TRUE(contains(text, \"exit code 2\"));",
                           "EXPECT_NE(decode(a), b);", "EXPECT_TRUE(done) << run.code;"}) {
    EXPECT_FALSE(std::regex_search(text, loose)) << text;
  }
}

TEST(Ladder, TestsCompareExitCodesExactly) {
  // "Not 0" is true of a crash as well.
  const std::regex loose = looseExitCode();
  forEachSource({"tests"}, [&](const fs::path& file, const std::string& text) {
    if (file.stem() == "ladder_test") return;
    std::smatch found;
    EXPECT_FALSE(std::regex_search(text, found, loose)) << file << ": " << found[0];
  });
}

}  // namespace
