#include "vir/core/loaded_pages.h"

#include <gtest/gtest.h>

#include <fstream>
#include <stdexcept>
#include <string>

#include "vir/core/settings.h"

namespace vir {
namespace {

/// Resident pages of files [kB].
long residentOfFiles() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    long kb = 0;
    if (word == "RssFile:" && status >> kb) return kb;
  }
  return 0;
}

TEST(LoadedPages, AreLetGoOfAndReadAgain) {
  if (residentOfFiles() == 0) GTEST_SKIP() << "the system does not tell what is resident";
  const long before = residentOfFiles();
  releaseLoadedPages();
  const long after = residentOfFiles();
  // A test binary links MRPT's settings, hence megabytes of libraries.
  EXPECT_LT(after, before * 3 / 4) << before << " kB before";
  // Code, exceptions (which read the tables of every frame) and what was relocated still work.
  EXPECT_THROW(throw std::runtime_error("here"), std::runtime_error);
  Settings settings;
  settings.set("Estimator.driver=vir");
  EXPECT_THROW(settings.set("no key at all"), SettingsError);
  releaseLoadedPages();
  EXPECT_LT(residentOfFiles(), before);
}

}  // namespace
}  // namespace vir
