#include "emulated_air.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <stdexcept>

namespace vir::emulator {

namespace fs = std::filesystem;

namespace {

constexpr const char* kEnding = ".radio";

sockaddr_un addressOf(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path) {
    throw std::runtime_error(path + ": is too long a name for a socket; name a shorter folder");
  }
  std::memcpy(address.sun_path, path.data(), path.size());
  return address;
}

}  // namespace

EmulatedAir::EmulatedAir(const AirOptions& options, int own_id)
    : options_(options),
      own_id_(own_id),
      own_path_(options.folder + "/" + std::to_string(own_id) + kEnding),
      random_(static_cast<std::uint64_t>(options.seed)) {
  const sockaddr_un address = addressOf(own_path_);
  std::error_code ignored;
  fs::create_directories(options.folder, ignored);
  fs::remove(own_path_, ignored);
  socket_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (socket_ >= 0 &&
      ::bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) {
    return;
  }
  const std::string why = std::strerror(errno);
  if (socket_ >= 0) ::close(socket_);
  throw std::runtime_error(own_path_ + ": cannot be made: " + why);
}

EmulatedAir::~EmulatedAir() {
  ::close(socket_);
  std::error_code ignored;
  fs::remove(own_path_, ignored);
}

void EmulatedAir::send(const std::string& bytes) {
  const std::string packet = static_cast<char>(own_id_) + bytes;
  std::error_code ignored;
  for (const auto& other : fs::directory_iterator(options_.folder, ignored)) {
    if (other.path().extension() != kEnding || other.path() == own_path_) continue;
    const sockaddr_un to = addressOf(other.path().string());
    // One that is no more does not hear it.
    ::sendto(socket_, packet.data(), packet.size(), 0, reinterpret_cast<const sockaddr*>(&to),
             sizeof to);
  }
}

std::vector<AirPacket> EmulatedAir::take() {
  std::vector<AirPacket> out;
  char buffer[1024];
  for (;;) {
    const ssize_t n = ::recv(socket_, buffer, sizeof buffer, 0);
    if (n < 2) return out;
    AirPacket packet{static_cast<unsigned char>(buffer[0]),
                     std::string(buffer + 1, static_cast<std::size_t>(n - 1))};
    if (random_.uniform() < options_.lost) continue;
    if (random_.uniform() < options_.damaged) {
      const auto at =
          static_cast<std::size_t>(random_.uniform(0, static_cast<double>(packet.bytes.size())));
      packet.bytes[at] = static_cast<char>(packet.bytes[at] ^ 0x55);
    }
    out.push_back(std::move(packet));
  }
}

}  // namespace vir::emulator
