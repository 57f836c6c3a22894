#pragma once
#include <sys/types.h>

#include <string>
#include <vector>

namespace vir::app {

/// How a program ended.
struct ChildExit {
  bool ok = false;      ///< exit code 0
  std::string problem;  ///< exit code, signal or timeout in words; empty if ok
};

/// A program that runs beside this one, its output in a file. Killed with the object.
class ChildProcess {
 public:
  /// Throws std::runtime_error if the file or the process cannot be made. `program` is a path,
  /// `arguments` what follows it.
  ChildProcess(const std::string& program, const std::vector<std::string>& arguments,
               const std::string& output_file);
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// True once it has ended; does not wait.
  bool finished();
  /// Ends it; `why` becomes the problem.
  void kill(const std::string& why);
  /// Since its start, on the wall.
  double seconds() const;
  /// Of a finished one.
  const ChildExit& exit() const { return exit_; }

 private:
  void ended(int status);

  pid_t pid_ = -1;
  double started_s_ = 0;
  bool running_ = false;
  std::string killed_because_;
  ChildExit exit_;
};

/// Path of the program that is running. Throws std::runtime_error if the system does not tell.
std::string ownProgram();

}  // namespace vir::app
