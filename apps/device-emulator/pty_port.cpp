#include "pty_port.h"

#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <stdexcept>

namespace vir::emulator {

namespace fs = std::filesystem;

PtyPort::~PtyPort() { pullOut(); }

void PtyPort::plugIn() {
  if (!link_.empty() && fs::exists(fs::symlink_status(link_)) && !fs::is_symlink(link_)) {
    throw std::runtime_error(link_ + ": is there already and no symbolic link; name another");
  }
  master_ = ::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  char name[128];
  if (master_ < 0 || ::grantpt(master_) != 0 || ::unlockpt(master_) != 0 ||
      ::ptsname_r(master_, name, sizeof name) != 0) {
    throw std::runtime_error(std::string("no pseudo-terminal to be had: ") + std::strerror(errno));
  }
  name_ = name;
  // Raw from the start, or what is sent before the reader has set it up would come back as an echo.
  // Closing it makes hasReader() tell the truth, too.
  const int slave = ::open(name, O_RDWR | O_NOCTTY | O_CLOEXEC);
  termios t{};
  if (slave >= 0 && ::tcgetattr(slave, &t) == 0) {
    ::cfmakeraw(&t);
    ::tcsetattr(slave, TCSANOW, &t);
  }
  if (slave >= 0) ::close(slave);
  if (link_.empty()) return;
  std::error_code ignored;
  fs::remove(link_, ignored);
  fs::create_symlink(name_, link_);
}

void PtyPort::pullOut() {
  if (master_ < 0) return;
  std::error_code ignored;
  if (!link_.empty()) fs::remove(link_, ignored);
  ::close(master_);
  master_ = -1;
  name_.clear();
}

bool PtyPort::hasReader() const {
  if (master_ < 0) return false;
  pollfd p{master_, POLLIN, 0};
  ::poll(&p, 1, 0);
  return (p.revents & POLLHUP) == 0;
}

std::size_t PtyPort::write(const std::string& bytes) {
  if (master_ < 0) return 0;
  const ssize_t n = ::write(master_, bytes.data(), bytes.size());
  return n > 0 ? static_cast<std::size_t>(n) : 0;
}

std::string PtyPort::read() {
  char buffer[1024];
  const ssize_t n = master_ < 0 ? 0 : ::read(master_, buffer, sizeof buffer);
  return n > 0 ? std::string(buffer, static_cast<std::size_t>(n)) : std::string();
}

}  // namespace vir::emulator
