/// The Debian packages, unpacked into a root of their own.
#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <regex>
#include <set>
#include <sstream>

#include "install_tree.h"

namespace vir {
namespace {

namespace fs = std::filesystem;
using test::contains;
using test::Outcome;
using test::quoted;

/// The packages of this build.
class Packages : public testing::Test {
 protected:
  void SetUp() override {
    const Outcome made =
        test::shell(quoted(test::sourceDir() + "/scripts/package.sh") + " --no-build --build-dir " +
                    quoted(test::buildDir()) + " --out " + quoted((folder_ / "debs").string()));
    ASSERT_EQ(made.code, 0) << made.text;
    for (const auto& item : fs::directory_iterator(folder_ / "debs")) {
      const std::string name = item.path().filename().string();
      ASSERT_TRUE(std::regex_match(name, std::regex("(libvir-slam-dev|vir-slam)_[0-9.]+_.*\\.deb")))
          << name;
      (name[0] == 'l' ? dev_ : program_) = quoted(item.path().string());
    }
    ASSERT_FALSE(dev_.empty() || program_.empty()) << made.text;
  }

  static std::string field(const std::string& package, const std::string& name) {
    return test::shell("dpkg-deb -f " + package + " " + name).text;
  }
  static std::set<std::string> files(const std::string& package) {
    const Outcome list = test::shell("dpkg-deb --fsys-tarfile " + package + " | tar -t");
    std::istringstream lines(list.text);
    std::set<std::string> out;
    for (std::string line; std::getline(lines, line);) {
      if (!line.empty() && line.back() != '/') out.insert(line);
    }
    return out;
  }

  /// Man pages and completion, which are made when the programs are built.
  static void expectDescriptions(const std::set<std::string>& files) {
    for (const char* page :
         {"vir-slam", "vir-slam-import", "vir-slam-check", "vir-slam-run", "vir-slam-calibrate",
          "vir-slam-calibrate-camera", "vir-slam-calibrate-uwb", "vir-slam-simulate",
          "vir-slam-record", "vir-slam-rendezvous", "vir-slam-evaluate", "vir-slam-batch",
          "vir-slam-export", "vir-slam-plugins", "vir-device-emulator"}) {
      const std::string file = std::string("./usr/share/man/man1/") + page + ".1.gz";
      EXPECT_EQ(files.count(file), 1u) << file << " is missing";
    }
    for (const char* program : {"vir-slam", "vir-device-emulator"}) {
      const std::string file = std::string("./usr/share/bash-completion/completions/") + program;
      EXPECT_EQ(files.count(file), 1u) << file << " is missing";
    }
  }

  test::TempFolder folder_;
  std::string program_, dev_;
};

TEST_F(Packages, RunTheSampleFromARootOfTheirOwn) {
  EXPECT_TRUE(contains(field(program_, "Depends"), "libmrpt-obs")) << field(program_, "Depends");
  EXPECT_TRUE(contains(field(program_, "Depends"), "libopencv-core")) << field(program_, "Depends");
  for (const char* needed : {"vir-slam (= ", "libeigen3-dev", "libceres-dev", "zlib1g-dev",
                             "liblz4-dev", "libsqlite3-dev"}) {
    EXPECT_TRUE(contains(field(dev_, "Depends"), needed)) << needed << " is missing";
  }
  const std::set<std::string> program = files(program_), dev = files(dev_);
  std::vector<std::string> twice;
  std::set_intersection(program.begin(), program.end(), dev.begin(), dev.end(),
                        std::back_inserter(twice));
  EXPECT_TRUE(twice.empty()) << twice.front() << " is in both packages";
  expectDescriptions(program);

  const std::string root = (folder_ / "root").string();
  for (const std::string& package : {program_, dev_}) {
    ASSERT_EQ(test::shell("dpkg-deb -x " + package + " " + quoted(root)).code, 0);
  }
  const Outcome run = test::shell(
      quoted(root + "/usr/bin/vir-slam") + " run " +
      quoted(root + "/usr/share/vir-slam/ini/euroc.ini") + " --rawlog " +
      quoted(test::sourceDir() + "/rawlog/two_A.rawlog") + " --out " + quoted(root + "/out"));
  ASSERT_EQ(run.code, 0) << run.text;
  const std::string summary = test::readText(root + "/out/summary.json");
  std::smatch ate;
  ASSERT_TRUE(std::regex_search(summary, ate, std::regex("\"ate_posyaw_m\": ([0-9.e-]+)")));
  EXPECT_LT(std::stod(ate[1]), 0.25);

  const fs::path build = folder_ / "build";
  test::buildExample("estimator_plugin", build, root + "/usr");
  const Outcome plugins = test::shell(quoted(root + "/usr/bin/vir-slam") + " --plugin-dir " +
                                      quoted(build.string()) + " plugins");
  EXPECT_TRUE(contains(plugins.text, "inertial")) << plugins.text;
}

}  // namespace
}  // namespace vir
