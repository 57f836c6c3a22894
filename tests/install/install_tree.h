#pragma once
/// The install tree that ctest makes before these tests, and projects built against it.
#include <filesystem>
#include <stdexcept>
#include <string>

#include "vir_test_paths.h"
#include "vir_test_shell.h"
#include "vir_test_temp_folder.h"

namespace vir::test {

inline std::filesystem::path installTree() {
  const std::filesystem::path tree = buildDir() + "/tests/install/tree";
  if (!std::filesystem::exists(tree)) {
    throw std::runtime_error(
        "there is no install tree: run these tests with ctest, which makes it");
  }
  return tree;
}

/// `vir-slam ARGUMENTS` as installed.
inline Outcome installedVirSlam(const std::string& arguments) {
  return shell(quoted((installTree() / "bin" / "vir-slam").string()) + " " + arguments);
}

inline bool succeeded(const Outcome& outcome) { return outcome.code == 0; }

/// Configures the project in `source` against what is installed below `prefix`.
inline Outcome configure(const std::string& source, const std::filesystem::path& build,
                         const std::string& prefix = installTree().string()) {
  return shell("cmake -S " + quoted(source) + " -B " + quoted(build.string()) +
               " -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH=" + quoted(prefix) +
               " -DCMAKE_CXX_FLAGS='-Wall -Wextra -Werror'"
               // By relative paths, so that a folder of another name finds the same objects.
               " \"-DCMAKE_CXX_COMPILER_LAUNCHER=env;CCACHE_BASEDIR=/;CCACHE_NOHASHDIR=1;"
               "$(command -v ccache)\"");
}

/// Configures and builds examples/NAME into `build`; throws with what was said if it fails.
inline void buildExample(const std::string& name, const std::filesystem::path& build,
                         const std::string& prefix = installTree().string()) {
  const Outcome configured = configure(sourceDir() + "/examples/" + name, build, prefix);
  if (!succeeded(configured)) throw std::runtime_error(configured.text);
  const Outcome built = shell("cmake --build " + quoted(build.string()));
  if (!succeeded(built)) throw std::runtime_error(built.text);
}

}  // namespace vir::test
