/// What grows with a run does not grow in memory.
#include "kept_rows.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <csignal>
#include <filesystem>

#include "vir_test_temp_folder.h"

namespace vir::results {
namespace {

struct Row {
  int i;
  double x;
};

TEST(KeptRows, GivesBackAllInOrderAndLeavesNoFile) {
  const test::TempFolder folder;
  for (const int n : {0, 3, 10, 11, 95}) {
    KeptRows<Row> rows(folder.path().string(), 10);
    for (int i = 0; i < n; ++i) rows.add({i, 0.1 * i});
    EXPECT_EQ(rows.size(), static_cast<std::size_t>(n));
    for (int again = 0; again < 2; ++again) {
      const std::vector<Row> all = rows.all();
      ASSERT_EQ(all.size(), static_cast<std::size_t>(n));
      for (int i = 0; i < n; ++i) {
        EXPECT_EQ(all[static_cast<std::size_t>(i)].i, i);
        EXPECT_EQ(all[static_cast<std::size_t>(i)].x, 0.1 * i);
      }
    }
    EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  }
}

TEST(KeptRows, SaysThatTheDiskIsFullOrTheFolderGone) {
  const test::TempFolder folder;
  KeptRows<Row> nowhere((folder / "none").string(), 1);
  nowhere.add({1, 1});
  EXPECT_THROW(nowhere.add({2, 2}), std::runtime_error);
  const pid_t child = fork();
  if (child == 0) {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit size{50, 50};
    setrlimit(RLIMIT_FSIZE, &size);
    KeptRows<Row> rows(folder.path().string(), 2);
    try {
      for (int i = 0; i < 100; ++i) rows.add({i, 0});
    } catch (const std::runtime_error&) {
      _exit(3);
    }
    _exit(1);
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_EQ(WEXITSTATUS(status), 3);
}

}  // namespace
}  // namespace vir::results
