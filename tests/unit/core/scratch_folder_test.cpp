#include "vir/core/scratch_folder.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <stdexcept>

namespace vir {
namespace {
namespace fs = std::filesystem;

TEST(ScratchFolder, GoesWithWhatIsInIt) {
  fs::path path;
  {
    const ScratchFolder folder("vir_scratch");
    path = folder.path();
    EXPECT_TRUE(fs::is_directory(path));
    EXPECT_NE(path, ScratchFolder("vir_scratch").path());
    fs::create_directories(folder / "a/b");
    std::ofstream(folder / "a/b/file") << "something";
    EXPECT_TRUE(fs::exists(path / "a/b/file"));
  }
  EXPECT_FALSE(fs::exists(path));
}

TEST(ScratchFolder, WhereNoneCanBeMadeItSaysWhatToSet) {
  const ScratchFolder home("vir_scratch");
  const char* before = std::getenv("TMPDIR");
  const std::string kept = before ? before : "";
  setenv("TMPDIR", (home / "missing").c_str(), 1);
  std::string message;
  try {
    const ScratchFolder folder("vir_scratch");
  } catch (const std::runtime_error& e) {
    message = e.what();
  }
  if (before) {
    setenv("TMPDIR", kept.c_str(), 1);
  } else {
    unsetenv("TMPDIR");
  }
  EXPECT_NE(message.find("TMPDIR"), std::string::npos) << message;
}

}  // namespace
}  // namespace vir
