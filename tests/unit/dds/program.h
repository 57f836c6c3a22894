#pragma once
/// Programs of tests/unit/dds as processes of their own, on a domain of this process's.
#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <string>
#include <vector>

#include "vir_test_paths.h"

namespace vir::test {

/// Tests of other checkouts may run at the same time.
inline int ownDomain() { return 1 + getpid() % 100; }

class Program {
 public:
  /// `out`: a file for what it prints; empty: as this process's.
  Program(const std::string& name, std::vector<std::string> arguments,
          const std::string& out = "") {
    arguments.insert(arguments.begin(), buildDir() + "/bin/" + name);
    std::vector<char*> argv;
    for (std::string& a : arguments) argv.push_back(a.data());
    argv.push_back(nullptr);
    pid_ = fork();
    if (pid_ != 0) return;
    if (!out.empty()) dup2(open(out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644), STDOUT_FILENO);
    execv(argv[0], argv.data());
    _exit(126);
  }
  ~Program() {
    if (!ended_) end(SIGKILL);
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;
  /// Exit code, or -signal.
  int end(int signal = 0) {
    if (signal != 0) kill(pid_, signal);
    int status = 0;
    waitpid(pid_, &status, 0);
    ended_ = true;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }

 private:
  pid_t pid_ = -1;
  bool ended_ = false;
};

}  // namespace vir::test
