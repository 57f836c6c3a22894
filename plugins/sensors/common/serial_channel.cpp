/// Serial ports and pseudo-terminals: raw, 8 data bits, no parity, 1 stop bit, no flow control.
#include <fcntl.h>
#include <sys/file.h>
#include <termios.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "byte_fd.h"
#include "byte_source.h"

namespace vir {
namespace {

constexpr std::pair<int, speed_t> kSpeeds[] = {
    {1200, B1200},       {2400, B2400},       {4800, B4800},       {9600, B9600},
    {19200, B19200},     {38400, B38400},     {57600, B57600},     {115200, B115200},
    {230400, B230400},   {460800, B460800},   {500000, B500000},   {576000, B576000},
    {921600, B921600},   {1000000, B1000000}, {1152000, B1152000}, {1500000, B1500000},
    {2000000, B2000000}, {2500000, B2500000}, {3000000, B3000000}, {4000000, B4000000}};

std::string hintFor(int error) {
  if (error == EACCES) return " (is the user in group dialout?)";
  if (error == ENOENT) return " (is the device plugged in?)";
  if (error == EBUSY) return " (another program uses it)";
  return "";
}

class SerialChannel : public ByteChannel {
 public:
  explicit SerialChannel(ByteFd fd) : fd_(std::move(fd)) {}

  long read(std::uint8_t* buffer, std::size_t size, std::string* why) override {
    if (size == 0) return 0;
    const ssize_t n = ::read(fd_.get(), buffer, size);
    if (n > 0) return n;
    if (n < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR)) return 0;
    *why = n == 0 ? "the device is gone"
                  : std::string("the device is gone (") + std::strerror(errno) + ")";
    return -1;
  }
  bool write(const std::uint8_t* bytes, std::size_t size) override {
    return ::write(fd_.get(), bytes, size) == static_cast<ssize_t>(size);
  }
  int fd() const override { return fd_.get(); }

 private:
  ByteFd fd_;
};

class SerialOpener : public ChannelOpener {
 public:
  SerialOpener(std::string path, speed_t speed) : path_(std::move(path)), speed_(speed) {}

  std::unique_ptr<ByteChannel> open() override {
    ByteFd fd(::open(path_.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
    if (fd.get() < 0) fail("cannot be opened");
    // Two readers of one port would each get half of the bytes.
    if (::flock(fd.get(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
      throw DeviceError(path_ + ": another program or section of the ini reads it already");
    }
    termios t{};
    if (tcgetattr(fd.get(), &t) != 0) {
      throw DeviceError(path_ + ": is no serial port");
    }
    cfmakeraw(&t);
    t.c_cflag |= CLOCAL | CREAD;
    t.c_cflag &= ~static_cast<tcflag_t>(CSTOPB | CRTSCTS);
    t.c_cc[VMIN] = 1;  // so that a read of 0 bytes means the device is gone
    t.c_cc[VTIME] = 0;
    if (cfsetispeed(&t, speed_) != 0 || cfsetospeed(&t, speed_) != 0 ||
        tcsetattr(fd.get(), TCSANOW, &t) != 0) {
      fail("does not take its settings");
    }
    tcflush(fd.get(), TCIFLUSH);  // what lies there is of unknown age
    return std::make_unique<SerialChannel>(std::move(fd));
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    const int error = errno;
    throw DeviceError(path_ + ": " + what + ": " + std::strerror(error) + hintFor(error));
  }

  std::string path_;
  speed_t speed_;
};

}  // namespace

std::unique_ptr<ChannelOpener> serialOpener(const std::string& path, int baud) {
  std::string known;
  for (const auto& [number, speed] : kSpeeds) {
    if (number == baud) return std::make_unique<SerialOpener>(path, speed);
    known += " " + std::to_string(number);
  }
  throw DeviceError("baud = " + std::to_string(baud) + " is no rate of a serial port; there are" +
                    known);
}

}  // namespace vir
