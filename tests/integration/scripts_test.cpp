/// What scripts/ does before it does anything: bash reads every script, wrong arguments are
/// refused.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "vir_test_paths.h"
#include "vir_test_shell.h"
#include "vir_test_temp_folder.h"

namespace vir {
namespace {

namespace fs = std::filesystem;

const std::string kScripts = test::sourceDir() + "/scripts/";

std::string at(const fs::path& path) { return test::quoted(path.string()); }

TEST(Scripts, BashReadsThem) {
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(kScripts)) {
    if (entry.path().extension() == ".sh") found.push_back(entry.path());
  }
  std::sort(found.begin(), found.end());
  ASSERT_GT(found.size(), 10u);
  for (const fs::path& script : found) {
    const test::Outcome outcome = test::shell("bash -n " + at(script));
    EXPECT_EQ(outcome.code, 0) << outcome.text;
    EXPECT_EQ(outcome.text, "") << script;
  }
}

TEST(Scripts, WrongArgumentsAreRefusedByName) {
  for (const char* script : {"accuracy_table.sh", "build.sh", "check_arm64.sh", "check_debian13.sh",
                             "demo.sh", "install_dependencies.sh", "package.sh", "uwb_figure.sh"}) {
    const test::Outcome outcome = test::shell(at(kScripts + script) + " --no-such-argument");
    EXPECT_EQ(outcome.code, 2) << script << ": " << outcome.text;
    EXPECT_NE(outcome.text.find("--no-such-argument"), std::string::npos) << outcome.text;
  }
}

TEST(Scripts, NothingIsBuiltForAWordThatIsNone) {
  const test::Outcome sanitize = test::shell(at(kScripts + "sanitize.sh") + " everything");
  EXPECT_EQ(sanitize.code, 2) << sanitize.text;
  EXPECT_NE(sanitize.text.find("everything"), std::string::npos) << sanitize.text;
  EXPECT_EQ(test::shell(at(kScripts + "fuzz.sh") + " soon").code, 2);
  const test::Outcome table = test::shell(at(kScripts + "accuracy_table.sh") + " /no/such/folder");
  EXPECT_EQ(table.code, 2) << table.text;
  EXPECT_NE(table.text.find("/no/such/folder"), std::string::npos) << table.text;
  EXPECT_EQ(test::shell(at(kScripts + "accuracy_table.sh") + " --out").code, 2);
  EXPECT_EQ(test::shell(at(kScripts + "uwb_figure.sh") + " a b").code, 2);
  for (const char* wrong : {" --seconds 0", " --lost 2", " --late-s -1", " --program /nowhere"}) {
    const test::Outcome team =
        test::shell("python3 " + at(kScripts + "team_check.py") + " x" + wrong);
    EXPECT_EQ(team.code, 2) << wrong << team.text;
  }
  const test::Outcome help = test::shell(at(kScripts + "fuzz.sh") + " --help");
  EXPECT_EQ(help.code, 0) << help.text;
  EXPECT_NE(help.text.find("MINUTES"), std::string::npos) << help.text;
}

TEST(Scripts, TheArm64CheckSaysWhatIsWrongBeforeItBegins) {
  const std::string check = at(kScripts + "check_arm64.sh");
  const test::TempFolder folder;
  for (const char* arguments : {" --root", " --root ''", " --tests-only --reference"}) {
    const test::Outcome outcome = test::shell(check + arguments);
    EXPECT_EQ(outcome.code, 2) << arguments << ": " << outcome.text;
    EXPECT_NE(outcome.text.find("needs a path"), std::string::npos) << outcome.text;
  }

  // A folder with something else in it is not taken for its own, and left as it is.
  const fs::path notes = folder / "notes.txt";
  std::ofstream(notes) << "mine\n";
  const test::Outcome taken = test::shell(check + " --tests-only --root " + at(folder / ""));
  EXPECT_EQ(taken.code, 2) << taken.text;
  EXPECT_NE(taken.text.find("holds something else"), std::string::npos) << taken.text;
  EXPECT_EQ(std::distance(fs::directory_iterator(folder / ""), fs::directory_iterator()), 1);

  const test::Outcome blank = test::shell(check + " --tests-only --root " + at(folder / "a b"));
  EXPECT_EQ(blank.code, 2) << blank.text;
  EXPECT_FALSE(fs::exists(folder / "a b"));
}

TEST(Scripts, TheArm64CheckSaysWhichProgramIsMissing) {
  // Of all programs only those that the script needs to come so far.
  const test::TempFolder folder;
  fs::create_directory(folder / "bin");
  for (const char* program : {"dirname", "ls"}) {
    const test::Outcome where = test::shell(std::string("command -v ") + program);
    ASSERT_EQ(where.code, 0);
    fs::create_symlink(where.text.substr(0, where.text.find('\n')), folder / "bin" / program);
  }
  const test::Outcome outcome =
      test::shell("bash=$(command -v bash); PATH=" + at(folder / "bin") + " $bash " +
                  at(kScripts + "check_arm64.sh") + " --root " + at(folder / "root"));
  EXPECT_EQ(outcome.code, 3) << outcome.text;
  EXPECT_NE(outcome.text.find("install_dependencies.sh --arm64"), std::string::npos)
      << outcome.text;
  EXPECT_FALSE(fs::exists(folder / "root"));

  // The list of packages has what is missing.
  const test::Outcome list =
      test::shell(at(kScripts + "install_dependencies.sh") + " --arm64 --list");
  EXPECT_EQ(list.code, 0);
  for (const char* package : {"\ng++-aarch64-linux-gnu\n", "\nqemu-user-static\n"}) {
    EXPECT_NE(list.text.find(package), std::string::npos) << list.text;
  }
}

}  // namespace
}  // namespace vir
