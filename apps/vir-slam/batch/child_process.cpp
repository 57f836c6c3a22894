#include "batch/child_process.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <stdexcept>

#include "vir/core/resource_usage.h"

extern char** environ;

namespace vir::app {
namespace {

/// In the child, where only what is safe after fork() may be called.
[[noreturn]] void becomeProgram(char* const* argv, int out, pid_t parent) {
  // A group of its own: Ctrl-C reaches the parent, which decides what becomes of the child.
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  const int in = open("/dev/null", O_RDONLY);
  const bool ready = getppid() == parent && in >= 0 && dup2(in, STDIN_FILENO) >= 0 &&
                     dup2(out, STDOUT_FILENO) >= 0 && dup2(out, STDERR_FILENO) >= 0;
  if (in > STDERR_FILENO) close(in);
  if (ready) execve(argv[0], argv, environ);
  _exit(127);
}

}  // namespace

ChildProcess::ChildProcess(const std::string& program, const std::vector<std::string>& arguments,
                           const std::string& output_file)
    : started_s_(wallSeconds()) {
  const int out = open(output_file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (out < 0) {
    throw std::runtime_error("cannot write " + output_file + ": " + std::strerror(errno));
  }
  // Not beyond this program: should it be killed, its successor writes the same files.
  const pid_t parent = getpid();
  std::vector<char*> argv{const_cast<char*>(program.c_str())};
  for (const std::string& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
  argv.push_back(nullptr);
  pid_ = fork();
  if (pid_ == 0) becomeProgram(argv.data(), out, parent);
  const int error = errno;
  close(out);
  if (pid_ < 0) {
    throw std::runtime_error("cannot start " + program + ": " + std::strerror(error));
  }
  running_ = true;
}

ChildProcess::~ChildProcess() {
  if (!running_) return;
  ::kill(pid_, SIGKILL);
  waitpid(pid_, nullptr, 0);
}

bool ChildProcess::finished() {
  if (!running_) return true;
  int status = 0;
  if (waitpid(pid_, &status, WNOHANG) != pid_) return false;
  running_ = false;
  ended(status);
  return true;
}

void ChildProcess::ended(int status) {
  if (!killed_because_.empty()) {
    exit_.problem = killed_because_;
  } else if (WIFSIGNALED(status)) {
    exit_.problem = std::string("ended by signal ") + strsignal(WTERMSIG(status));
  } else if (WEXITSTATUS(status) != 0) {
    exit_.problem = "exit code " + std::to_string(WEXITSTATUS(status));
  } else {
    exit_.ok = true;
  }
}

void ChildProcess::kill(const std::string& why) {
  if (!running_) return;
  killed_because_ = why;
  ::kill(pid_, SIGKILL);
}

double ChildProcess::seconds() const { return wallSeconds() - started_s_; }

std::string ownProgram() { return std::filesystem::read_symlink("/proc/self/exe").string(); }

}  // namespace vir::app
