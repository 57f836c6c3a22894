#pragma once
/// Calls the program as a user does.
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>

#include "vir_test_paths.h"
#include "warm/warm_socket.h"

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

/// Starts the program that is loaded once for all calls of this process (warm/warm_program.cpp);
/// returns what calls it. The program itself where the other one was not built, or before it.
inline std::string startWarmProgram() {
  const std::string bin = test::buildDir() + "/bin/";
  const std::string plain = bin + "vir-slam", program = bin + "vir-slam-warm";
  struct stat plain_file {
  }, file{};
  if (stat(plain.c_str(), &plain_file) != 0 || stat(program.c_str(), &file) != 0 ||
      file.st_mtim.tv_sec < plain_file.st_mtim.tv_sec) {
    return quoted(plain);
  }
  const std::string name = "vir-slam-warm-" + std::to_string(getpid());
  const int listening = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  socklen_t size = 0;
  const sockaddr_un address = warmAddress(name, &size);
  if (listening < 0 || bind(listening, reinterpret_cast<const sockaddr*>(&address), size) != 0 ||
      listen(listening, 8) != 0) {
    throw std::runtime_error("cannot make a socket");
  }
  const std::string number = std::to_string(listening);
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("cannot start " + program);
  if (child == 0) {
    fcntl(listening, F_SETFD, 0);
    execl(program.c_str(), program.c_str(), "--listen", number.c_str(), nullptr);
    _exit(127);
  }
  close(listening);  // a call fails if the program could not be started
  setenv(kWarmSocket, name.c_str(), 1);
  return quoted(bin + "vir-slam-call");
}

/// `vir-slam ARGUMENTS`.
inline Outcome virSlam(const std::string& arguments) {
  static const std::string program = startWarmProgram();
  return shell(program + " " + arguments);
}

inline bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace vir::test
