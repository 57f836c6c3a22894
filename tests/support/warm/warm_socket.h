#pragma once
/// Between a test and the program it calls: see warm_program.cpp.
#include <sys/socket.h>
#include <sys/un.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <string>

namespace vir::test {

/// Environment variable with the name of the socket.
inline constexpr const char* kWarmSocket = "VIR_TEST_WARM_SOCKET";

/// What goes with a call: stdin, stdout, stderr.
inline constexpr int kStreams = 3;

/// A name that is no file and goes with the last process that has it open.
inline sockaddr_un warmAddress(const std::string& name, socklen_t* size) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path + 1, name.data(),
              std::min(name.size(), sizeof address.sun_path - 1));
  *size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size());
  return address;
}

inline bool sendAll(int socket, const char* data, std::size_t size) {
  while (size > 0) {
    const ssize_t n = send(socket, data, size, MSG_NOSIGNAL);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    data += n;
    size -= static_cast<std::size_t>(n);
  }
  return true;
}

/// False if it was closed before.
inline bool receiveAll(int socket, char* data, std::size_t size) {
  while (size > 0) {
    const ssize_t n = recv(socket, data, size, 0);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    data += n;
    size -= static_cast<std::size_t>(n);
  }
  return true;
}

}  // namespace vir::test
