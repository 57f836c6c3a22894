#pragma once
#include <unistd.h>

#include <utility>

namespace vir {

/// A file descriptor that closes itself.
class ByteFd {
 public:
  explicit ByteFd(int fd = -1) : fd_(fd) {}
  ~ByteFd() {
    if (fd_ >= 0) ::close(fd_);
  }
  ByteFd(ByteFd&& o) noexcept : fd_(std::exchange(o.fd_, -1)) {}
  ByteFd& operator=(ByteFd&& o) noexcept {
    std::swap(fd_, o.fd_);
    return *this;
  }
  int get() const { return fd_; }

 private:
  int fd_;
};

}  // namespace vir
