#include "vir/results/output_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <stdexcept>

namespace vir::results {
namespace fs = std::filesystem;
namespace {

constexpr int kTries = 100;

/// Whether the locked file is still the one of that name: who had it before may have removed it.
bool stillThere(int handle, const std::string& path) {
  struct stat ours {};
  struct stat named {};
  return fstat(handle, &ours) == 0 && stat(path.c_str(), &named) == 0 &&
         ours.st_ino == named.st_ino && ours.st_dev == named.st_dev;
}

}  // namespace

OutputLock::OutputLock(const std::string& target) {
  std::error_code ignored;
  const bool folder = fs::is_directory(target, ignored);
  const fs::path path(target);
  if (!folder) file_ = (path.parent_path() / ("." + path.filename().string() + ".lock")).string();
  const std::string& name = folder ? target : file_;
  const int flags =
      folder ? O_RDONLY | O_DIRECTORY | O_CLOEXEC : O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW;
  for (int i = 0; i < kTries; ++i) {
    handle_ = open(name.c_str(), flags, 0644);
    if (handle_ < 0) {
      throw std::runtime_error("cannot write " + name + ": " + std::strerror(errno));
    }
    const bool locked = flock(handle_, LOCK_EX | LOCK_NB) == 0;
    if (!locked && errno == EWOULDBLOCK) break;
    if (!locked || stillThere(handle_, name)) return;
    close(handle_);
  }
  close(handle_);
  throw std::runtime_error("another process is writing " + target +
                           "; wait for it, or choose another --out");
}

OutputLock::~OutputLock() {
  if (!file_.empty() && stillThere(handle_, file_)) unlink(file_.c_str());
  close(handle_);
}

}  // namespace vir::results
