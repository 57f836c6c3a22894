#pragma once
/// Where tests find recordings that are not part of the project.
#include <cstdlib>
#include <filesystem>
#include <string>

#include "vir_test_paths.h"

namespace vir::test {

/// VIR_TEST_DATA, else the folder shared/data beside the source tree.
inline std::filesystem::path dataFolder() {
  if (const char* given = std::getenv("VIR_TEST_DATA")) return given;
  return std::filesystem::path(test::sourceDir()) / ".." / "shared" / "data";
}

}  // namespace vir::test

/// Defines `var` as the path of `name` in the data folder, or skips the test.
#define VIR_REQUIRE_DATA(var, name)                                        \
  const std::filesystem::path var = ::vir::test::dataFolder() / (name);    \
  if (!std::filesystem::exists(var)) {                                     \
    GTEST_SKIP() << var << " is not here (set VIR_TEST_DATA to the data)"; \
  }                                                                        \
  static_assert(true, "")
