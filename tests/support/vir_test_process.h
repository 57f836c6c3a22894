#pragma once
/// The program as a process of its own that is disturbed while it works.
#include <linux/capability.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <vector>

#include "vir_test_clock.h"
#include "vir_test_paths.h"

namespace vir::test {

struct Limits {
  long file_bytes = -1;      ///< a file cannot become longer, as on a full disk
  long memory_mb = -1;       ///< address space
  bool mind_rights = false;  ///< root minds the rights of folders, as everybody does
  std::string clock;         ///< SettableClock::file(); empty: the machine's
};

class Process {
 public:
  /// `vir-slam ARGUMENTS`; its output must fit into a pipe.
  explicit Process(const std::vector<std::string>& arguments, const Limits& limits = {}) {
    std::vector<std::string> all{buildDir() + "/bin/vir-slam"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    std::vector<char*> argv;
    for (std::string& a : all) argv.push_back(a.data());
    argv.push_back(nullptr);
    int ends[2];
    if (pipe(ends) != 0) throw std::runtime_error("no pipe");
    pid_ = fork();
    if (pid_ == 0) become(argv.data(), ends[1], limits);
    close(ends[1]);
    out_ = ends[0];
    if (pid_ < 0) throw std::runtime_error("cannot fork");
  }
  ~Process() {
    if (running()) {
      kill(pid_, SIGKILL);
      wait();
    }
    close(out_);
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  bool running() {
    if (ended_) return false;
    ended_ = waitpid(pid_, &status_, WNOHANG) == pid_;
    return !ended_;
  }
  void send(int signal) {
    if (running()) kill(pid_, signal);
  }
  /// From now on the system gives it no more memory.
  void giveNoMoreMemory() {
    const rlimit none{1, 1};
    if (running()) prlimit(pid_, RLIMIT_AS, &none, nullptr);
  }
  /// Exit code, or -signal.
  int wait() {
    char buffer[4096];
    for (ssize_t n = 0; (n = read(out_, buffer, sizeof buffer)) > 0;) {
      text_.append(buffer, static_cast<std::size_t>(n));
    }
    if (!ended_) waitpid(pid_, &status_, 0);
    ended_ = true;
    return WIFEXITED(status_) ? WEXITSTATUS(status_) : -WTERMSIG(status_);
  }
  /// stdout and stderr, after wait().
  const std::string& text() const { return text_; }

 private:
  static void set(int what, long value) {
    const rlimit limit{static_cast<rlim_t>(value), static_cast<rlim_t>(value)};
    if (setrlimit(static_cast<__rlimit_resource>(what), &limit) != 0) _exit(126);
  }
  [[noreturn]] static void become(char** argv, int out, const Limits& limits) {
    dup2(out, STDOUT_FILENO);
    dup2(out, STDERR_FILENO);
    close(out);
    std::signal(SIGXFSZ, SIG_IGN);  // write() fails instead
    if (limits.file_bytes >= 0) set(RLIMIT_FSIZE, limits.file_bytes);
    if (limits.memory_mb >= 0) set(RLIMIT_AS, limits.memory_mb << 20);
    if (limits.mind_rights && geteuid() == 0 && prctl(PR_CAPBSET_DROP, CAP_DAC_OVERRIDE) != 0) {
      _exit(126);
    }
    if (!limits.clock.empty()) {
      setenv("LD_PRELOAD", SettableClock::library().c_str(), 1);
      setenv("VIR_TEST_CLOCK", limits.clock.c_str(), 1);
    }
    execv(argv[0], argv);
    _exit(126);
  }

  pid_t pid_ = -1;
  int out_ = -1, status_ = 0;
  bool ended_ = false;
  std::string text_;
};

}  // namespace vir::test
