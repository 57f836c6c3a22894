/// scripts/soak.sh: a minute of it, or VIR_SOAK_MINUTES.
#include <gtest/gtest.h>

#include <cstdlib>

#include "vir_test_shell.h"

namespace vir {
namespace {

TEST(Soak, HoldsWhileThingsGoWrong) {
#ifdef VIR_SANITIZED
  GTEST_SKIP() << "memory is not what it is without a sanitizer";
#endif
  const bool python = test::shell("command -v python3").code == 0;
  if (!python) GTEST_SKIP() << "needs python3";
  const char* minutes = std::getenv("VIR_SOAK_MINUTES");
  const test::Outcome outcome =
      test::shell(test::quoted(test::sourceDir() + "/scripts/soak.sh") + " --build-dir " +
                  test::quoted(test::buildDir()) + " " + (minutes == nullptr ? "1" : minutes));
  std::printf("%s", outcome.text.c_str());
  EXPECT_EQ(outcome.code, 0);
}

}  // namespace
}  // namespace vir
