#pragma once
#include <string>

namespace vir::results {

/// Keeps two processes from writing the same output: held while it lives, and gone with the process
/// however that ends. A folder is locked itself; for a file, `.NAME.lock` beside it exists so long.
class OutputLock {
 public:
  /// `target`: an existing folder, or a file, existing or not, in an existing folder. Throws
  /// std::runtime_error naming it if another process has it. Where the file system has no locks,
  /// nothing is locked.
  explicit OutputLock(const std::string& target);
  ~OutputLock();
  OutputLock(const OutputLock&) = delete;
  OutputLock& operator=(const OutputLock&) = delete;

 private:
  int handle_ = -1;
  std::string file_;  // to be removed; empty for a folder
};

}  // namespace vir::results
