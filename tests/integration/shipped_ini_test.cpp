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

TEST(ShippedIni, ReferenceIsWhatTheCodeSays) {
  const fs::path file = kIni / "reference.ini";
  ASSERT_TRUE(fs::exists(file)) << "make it with: vir-slam plugins vir > ini/reference.ini";
  EXPECT_TRUE(test::readText(file) == test::virSlam("plugins vir").text)
      << "an option changed; make it anew with: vir-slam plugins vir > ini/reference.ini";
}

}  // namespace
}  // namespace vir
