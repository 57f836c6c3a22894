#pragma once
/// Calls the program as a user does.
#include <sys/wait.h>

#include <cstdio>
#include <stdexcept>
#include <string>

#include "vir_test_paths.h"

namespace vir::test {

struct Outcome {
  int code = -1;
  std::string text;  ///< stdout and stderr
};

/// Runs `command` in a shell.
inline Outcome shell(const std::string& command) {
  FILE* pipe = popen(("(" + command + ") 2>&1").c_str(), "r");
  if (pipe == nullptr) throw std::runtime_error("cannot start a shell");
  Outcome outcome;
  char buffer[4096];
  for (std::size_t n = 0; (n = fread(buffer, 1, sizeof buffer, pipe)) > 0;) {
    outcome.text.append(buffer, n);
  }
  const int status = pclose(pipe);
  outcome.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return outcome;
}

inline std::string quoted(const std::string& text) { return "'" + text + "'"; }

/// `vir-slam ARGUMENTS`.
inline Outcome virSlam(const std::string& arguments) {
  return shell(quoted(test::buildDir() + "/bin/vir-slam") + " " + arguments);
}

inline bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace vir::test
