/// Every ini of the project says only what the program knows.
#include <gtest/gtest.h>

#include <filesystem>

#include "vir_test_paths.h"
#include "vir_test_rawlog.h"
#include "vir_test_shell.h"
#include "vir_test_temp_folder.h"

namespace vir {
namespace {

namespace fs = std::filesystem;
using test::Outcome;
using test::quoted;

const fs::path kIni = fs::path(test::sourceDir()) / "ini";

/// For `simulate`, not for `run`.
bool describesAWorld(const fs::path& ini) {
  return ini.filename().string().rfind("simulate_", 0) == 0;
}

/// For `batch`.
bool describesABenchmark(const fs::path& ini) {
  return ini.filename().string().rfind("benchmark", 0) == 0;
}

/// A recording without images is read to the end: what fails is the run (1), not the settings (2).
TEST(ShippedIni, EachIsAccepted) {
  const test::TempFolder folder;
  const std::string rawlog = (folder / "imu.rawlog").string();
  rawlog::RawlogWriter writer(rawlog);
  for (int i = 0; i < 20; ++i) writer.write(*test::imuAt(test::kStart + 5 * i * test::kMs));
  writer.finish();
  int seen = 0;
  for (const auto& item : fs::directory_iterator(kIni)) {
    if (item.path().extension() != ".ini" || describesAWorld(item.path()) ||
        describesABenchmark(item.path())) {
      continue;
    }
    ++seen;
    const Outcome outcome =
        test::virSlam("run " + quoted(item.path().string()) + " --rawlog " + quoted(rawlog) +
                      " --out " + quoted((folder / "out").string()));
    EXPECT_EQ(outcome.code, 1) << item.path() << "\n" << outcome.text;
    EXPECT_TRUE(test::contains(outcome.text, "no usable image")) << outcome.text;
  }
  EXPECT_GT(seen, 0);
}

TEST(ShippedIni, EachWorldCanBeSimulated) {
  const test::TempFolder folder;
  int seen = 0;
  for (const auto& item : fs::directory_iterator(kIni)) {
    if (!describesAWorld(item.path())) continue;
    ++seen;
    const Outcome outcome =
        test::virSlam("simulate " + quoted(item.path().string()) + " --out " +
                      quoted((folder / "w.rawlog").string()) + " --set simulator.images=none");
    EXPECT_EQ(outcome.code, 0) << item.path() << "\n" << outcome.text;
  }
  EXPECT_GT(seen, 0);
}

TEST(ShippedIni, EachBenchmarkIsAccepted) {
  int seen = 0;
  for (const auto& item : fs::directory_iterator(kIni)) {
    if (!describesABenchmark(item.path())) continue;
    ++seen;
    const Outcome outcome = test::virSlam("batch " + quoted(item.path().string()) + " --list");
    EXPECT_EQ(outcome.code, 0) << outcome.text;
    EXPECT_TRUE(test::contains(outcome.text, "eight-hard-0/ours")) << outcome.text;
  }
  EXPECT_GT(seen, 0);
}

/// None of its devices is there: the settings of all three are read, and each is waited for.
TEST(ShippedIni, TheRobotsSensorsAreAccepted) {
  const test::TempFolder folder;
  std::string command = "record " + quoted((kIni / "robot.ini").string()) +
                        " --estimate --duration-s 0.2 --results " +
                        quoted((folder / "results").string()) +
                        " --set Recording.stream_port=0 --set cam0.cv_camera_index=99";
  for (const char* sensor : {"imu0", "uwb0"}) {
    command += std::string(" --set ") + sensor + ".port=/dev/there-is-none";
  }
  for (const char* sensor : {"cam0", "imu0", "uwb0"}) {
    command += std::string(" --set ") + sensor + ".optional=true";
  }
  const auto recordTo = [&](const std::string& name, const std::string& more) {
    return test::virSlam(command + more + " --out " + quoted((folder / name).string()));
  };
  const Outcome outcome = recordTo("a.rawlog", "");
  EXPECT_TRUE(test::contains(outcome.text, "recording 3 sensors to ")) << outcome.text;
  for (const char* key : {"imu0.no_such_key", "uwb0.no_such_key", "Ranges.no_such_key"}) {
    const Outcome wrong = recordTo("b.rawlog", std::string(" --set ") + key + "=1");
    EXPECT_EQ(wrong.code, 2) << key << "\n" << wrong.text;
  }
}

TEST(ShippedIni, ReferenceIsWhatTheCodeSays) {
  const fs::path file = kIni / "reference.ini";
  ASSERT_TRUE(fs::exists(file)) << "make it with: vir-slam plugins vir > ini/reference.ini";
  EXPECT_TRUE(test::readText(file) == test::virSlam("plugins vir").text)
      << "an option changed; make it anew with: vir-slam plugins vir > ini/reference.ini";
}

}  // namespace
}  // namespace vir
