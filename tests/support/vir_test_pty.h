#pragma once
/// A pseudo-terminal whose other end the test holds, behind a symbolic link that stays the same
/// when the device is pulled out and put in again.
#include <fcntl.h>
#include <pty.h>
#include <termios.h>
#include <unistd.h>

#include <filesystem>
#include <stdexcept>
#include <string>

namespace vir::test {

class Pty {
 public:
  explicit Pty(std::filesystem::path link) : link_(std::move(link)) { plugIn(); }
  ~Pty() { pullOut(); }
  Pty(const Pty&) = delete;
  Pty& operator=(const Pty&) = delete;

  void plugIn() {
    int slave = -1;
    char name[256];
    if (openpty(&master_, &slave, name, nullptr, nullptr) != 0) {
      throw std::runtime_error("no pseudo-terminal to be had");
    }
    termios t{};
    tcgetattr(slave, &t);
    cfmakeraw(&t);
    tcsetattr(slave, TCSANOW, &t);
    ::close(slave);
    fcntl(master_, F_SETFL, O_NONBLOCK);
    std::filesystem::remove(link_);
    std::filesystem::create_symlink(name, link_);
  }
  void pullOut() {
    std::error_code ignored;
    std::filesystem::remove(link_, ignored);
    if (master_ >= 0) ::close(master_);
    master_ = -1;
  }
  void send(const std::string& bytes) {
    if (::write(master_, bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size())) {
      throw std::runtime_error("the pseudo-terminal does not take it");
    }
  }
  /// What the driver has sent.
  std::string received() {
    char buffer[4096];
    const ssize_t n = ::read(master_, buffer, sizeof buffer);
    return n > 0 ? std::string(buffer, static_cast<std::size_t>(n)) : std::string();
  }
  std::string path() const { return link_.string(); }

 private:
  std::filesystem::path link_;
  int master_ = -1;
};

}  // namespace vir::test
