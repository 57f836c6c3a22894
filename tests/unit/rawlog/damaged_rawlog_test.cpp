/// A damaged recording gives what comes before the damage and says so; it never throws in the
/// middle, hangs or ends in silence.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>

#include "vir/rawlog/rawlog_reader.h"
#include "vir_test_rawlog.h"
#include "vir_test_temp_folder.h"

namespace vir::rawlog {
namespace {

using test::imuAt;
using test::kStart;
using test::TempFolder;

struct Outcome {
  std::size_t observations = 0;
  std::string damage;
};

Outcome readAll(const std::filesystem::path& path) {
  RawlogReader reader(path.string());
  Outcome outcome;
  while (reader.next()) ++outcome.observations;
  outcome.damage = reader.damage();
  return outcome;
}

std::string recording(const TempFolder& folder, int compression) {
  const auto path = folder / "whole.rawlog";
  RawlogWriter writer(path.string(), compression);
  for (int i = 0; i < 200; ++i) writer.write(*imuAt(kStart + i * test::kMs));
  writer.finish();
  return test::readText(path);
}

std::string openError(const std::string& path) {
  try {
    RawlogReader reader(path);
  } catch (const std::runtime_error& e) {
    return e.what();
  }
  return "no error";
}

TEST(DamagedRawlog, FilesThatCannotBeOpened) {
  const TempFolder folder;
  EXPECT_EQ(openError("/nowhere/a.rawlog"), "there is no such rawlog: /nowhere/a.rawlog");
  EXPECT_EQ(openError(folder.path().string()),
            "not a rawlog but a folder: " + folder.path().string());
  test::writeText(folder / "empty.rawlog", "");
  EXPECT_EQ(openError((folder / "empty.rawlog").string()),
            "the rawlog is empty: " + (folder / "empty.rawlog").string());
}

TEST(DamagedRawlog, Junk) {
  const TempFolder folder;
  std::string binary;
  for (int i = 0; i < 5000; ++i) binary += static_cast<char>((i * 7919) >> 3);
  for (const std::string& junk :
       {std::string("this is not a rawlog\n"), binary, std::string(1, 'x')}) {
    test::writeText(folder / "junk.rawlog", junk);
    const Outcome outcome = readAll(folder / "junk.rawlog");
    EXPECT_EQ(outcome.observations, 0u);
    EXPECT_NE(outcome.damage.find("damaged or cut off after 0 objects"), std::string::npos)
        << outcome.damage;
    EXPECT_EQ(outcome.damage.find('\n'), std::string::npos) << outcome.damage;
  }
}

TEST(DamagedRawlog, CutAnywhere) {
  for (const int compression : {0, 1}) {
    const TempFolder folder;
    const std::string whole = recording(folder, compression);
    std::size_t last = 0;
    for (std::size_t i = 1; i < 20; ++i) {
      test::writeText(folder / "cut.rawlog", whole.substr(0, whole.size() * i / 20));
      const Outcome outcome = readAll(folder / "cut.rawlog");
      EXPECT_GE(outcome.observations, last);
      EXPECT_LT(outcome.observations, 200u);
      EXPECT_NE(outcome.damage, "") << "cut at " << i << "/20, compression " << compression;
      last = outcome.observations;
    }
    EXPECT_GT(last, compression == 0 ? 180u : 0u);
  }
}

/// Of a recording with an object of each kind, wherever it ends: what comes before, and a word.
/// What is not packed is in a gzip frame as well, so that no cut looks like the end.
TEST(DamagedRawlog, CutAtEveryByte) {
  for (const int compression : {0, 1}) {
    const TempFolder folder;
    {
      RawlogWriter writer((folder / "whole.rawlog").string(), compression);
      writer.write(*imuAt(kStart));
      writer.write(*test::rangeAt(kStart + test::kMs, 3));
      writer.write(*test::imageAt(kStart + 2 * test::kMs));
      writer.write(*test::truthAt(kStart + 3 * test::kMs, 1));
      writer.finish();
    }
    const std::string whole = test::readText(folder / "whole.rawlog");
    ASSERT_EQ(readAll(folder / "whole.rawlog").observations, 4u);
    std::size_t last = 0, silent = 0;
    for (std::size_t n = 1; n < whole.size(); ++n) {
      test::writeText(folder / "cut.rawlog", whole.substr(0, n));
      const Outcome outcome = readAll(folder / "cut.rawlog");
      ASSERT_GE(outcome.observations, last) << n;
      ASSERT_LE(outcome.observations, 4u) << n;
      last = outcome.observations;
      if (outcome.damage.empty()) ++silent;
    }
    EXPECT_EQ(silent, 0u) << "compression " << compression;
    EXPECT_GE(last, 3u);
  }
}

/// The checksum at the end is all that is missing: every object is there, and the cut is reported.
TEST(DamagedRawlog, CutInTheChecksum) {
  const TempFolder folder;
  const std::string whole = recording(folder, 1);
  test::writeText(folder / "cut.rawlog", whole.substr(0, whole.size() - 4));
  const Outcome outcome = readAll(folder / "cut.rawlog");
  EXPECT_EQ(outcome.observations, 200u);
  EXPECT_NE(outcome.damage, "");
}

TEST(DamagedRawlog, FlippedBits) {
  const TempFolder folder;
  const std::string whole = recording(folder, 0);
  for (std::size_t i = 20; i + 8 < whole.size(); i += whole.size() / 101) {
    for (const int bit : {0, 6}) {
      std::string flipped = whole;
      flipped[i] = static_cast<char>(flipped[i] ^ (1 << bit));
      test::writeText(folder / "flipped.rawlog", flipped);
      const Outcome outcome = readAll(folder / "flipped.rawlog");  // must come back
      EXPECT_NE(outcome.damage, "") << "byte " << i << " bit " << bit;
    }
  }
}

TEST(DamagedRawlog, TargetsThatCannotBeWritten) {
  const TempFolder folder;
  test::writeText(folder / "file", "x");
  for (const std::string& path :
       {folder.path().string(), (folder / "file/a.rawlog").string(), std::string()}) {
    EXPECT_THROW(RawlogWriter{path}, std::runtime_error) << path;
  }
}

/// A limit on the size of files stands in for a full disk.
TEST(DamagedRawlog, FullDiskIsReportedAndLeavesNoFile) {
  const TempFolder folder;
  const auto path = folder / "a.rawlog";
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  rlimit small = before;
  small.rlim_cur = 100'000;
  std::signal(SIGXFSZ, SIG_IGN);
  setrlimit(RLIMIT_FSIZE, &small);
  std::string error;
  try {
    RawlogWriter writer(path.string(), 0);
    for (int i = 0; i < 2000; ++i) writer.write(*imuAt(kStart + i));
    writer.finish();
  } catch (const std::exception& e) {
    error = e.what();
  }
  setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_NE(error.find("a.rawlog"), std::string::npos) << error;
  EXPECT_NE(error.find("File too large"), std::string::npos) << error;
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

}  // namespace
}  // namespace vir::rawlog
