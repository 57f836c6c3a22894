/// What a start of the program loads. MRPT's drivers and windows bring wxWidgets, Qt, FFmpeg and
/// others, 170 libraries and a quarter of a second of CPU time, that only sensors and windows need.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <set>

#include "vir_test_rawlog.h"
#include "vir_test_shell.h"
#include "vir_test_temp_folder.h"

namespace vir {
namespace {

namespace fs = std::filesystem;
using test::quoted;

/// The program itself, not the one that is loaded once for many calls.
class Libraries : public testing::Test {
 protected:
  /// Names of all shared objects that a call maps at any time, as the dynamic linker tells.
  std::set<std::string> loadedBy(const std::string& arguments) {
    fs::remove_all(folder_ / "ld");
    fs::create_directories(folder_ / "ld");
    outcome_ = test::shell("LD_DEBUG=files LD_DEBUG_OUTPUT=" + quoted(path("ld/log")) + " " +
                           quoted(test::buildDir() + "/bin/vir-slam") + " " + arguments);
    std::set<std::string> names;
    const std::regex line("file=(\\S+) \\[[0-9]+\\];  generating link map");
    for (const auto& item : fs::directory_iterator(folder_ / "ld")) {
      std::ifstream log(item.path());
      std::smatch match;
      for (std::string text; std::getline(log, text);) {
        if (!std::regex_search(text, match, line)) continue;
        names.insert(fs::path(match[1].str()).filename().string());
      }
    }
    EXPECT_TRUE(anyOf(names, {"libvir_roles"})) << "the linker's log is not understood";
    return names;
  }

  static bool anyOf(const std::set<std::string>& names, const std::vector<std::string>& parts) {
    for (const std::string& name : names) {
      for (const std::string& part : parts) {
        if (name.find(part) != std::string::npos) return true;
      }
    }
    return false;
  }

  void expectLean(const std::string& arguments, int code) {
    const std::set<std::string> names = loadedBy(arguments);
    EXPECT_EQ(outcome_.code, code) << outcome_.text;
    for (const char* part :
         {"mrpt-hwdrivers", "mrpt-gui", "mrpt-vision", "libwx_", "libQt5", "libgtk", "avcodec",
          "opencv_videoio", "opencv_highgui", "vir_sensor_roles", "vir_live_view"}) {
      EXPECT_FALSE(anyOf(names, {part})) << arguments << " loads " << part;
    }
    EXPECT_LT(names.size(), 250u) << arguments;
  }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  test::TempFolder folder_;
  test::Outcome outcome_;
};

TEST_F(Libraries, OfARunAreFew) {
  test::writeRecording(path("a.rawlog"), 5);
  test::writeText(path("a.ini"), "[Estimator]\ndriver = vir\n");
  const std::string arguments = "run " + quoted(path("a.ini")) + " --rawlog " +
                                quoted(path("a.rawlog")) + " --out " + quoted(path("out"));
  expectLean(arguments, 1);  // five images: no pose
  EXPECT_TRUE(anyOf(loadedBy(arguments), {"vir_plugin_vir", "vir_plugin_odometry"}));
}

TEST_F(Libraries, OfHelpEvaluateAndRendezvousAreFew) {
  expectLean("--help", 0);
  test::writeText(path("a.tum"), "1 0 0 0 0 0 0 1\n2 1 0 0 0 0 0 1\n3 1 1 0 0 0 0 1\n");
  expectLean(
      "evaluate --align none --reference " + quoted(path("a.tum")) + " " + quoted(path("a.tum")),
      0);
  test::writeText(path("two.ini"), "[Rendezvous]\ndriver = nlopt\n");
  expectLean("rendezvous " + quoted(path("two.ini")), 2);  // no recording is named
}

TEST_F(Libraries, OfASensorAreLoadedWhenOneIsAskedFor) {
  const std::set<std::string> names = loadedBy("plugins simulator");
  EXPECT_EQ(outcome_.code, 0) << outcome_.text;
  EXPECT_TRUE(anyOf(names, {"mrpt-hwdrivers"}));
}

}  // namespace
}  // namespace vir
