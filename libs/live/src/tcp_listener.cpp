#include "vir/live/tcp_listener.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <stdexcept>

namespace vir::live {
namespace {

constexpr int kBacklog = 128;
constexpr rlim_t kSpareDescriptors = 32;  // that the rest of the program can still open

/// The lowest free number is taken, so that a high one tells that few are left.
bool isAmongTheLast(int handle) {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return false;
  return static_cast<rlim_t>(handle) + kSpareDescriptors >= limit.rlim_cur;
}

std::runtime_error cannotListen(const std::string& address, int port, const std::string& why) {
  return std::runtime_error("cannot listen on " + address + ":" + std::to_string(port) + ": " +
                            why);
}

}  // namespace

TcpListener::TcpListener(const std::string& address, int port) {
  sockaddr_in at{};
  at.sin_family = AF_INET;
  at.sin_port = htons(static_cast<std::uint16_t>(port));
  if (inet_pton(AF_INET, address.c_str(), &at.sin_addr) != 1) {
    throw cannotListen(address, port, "not an IPv4 address, e.g. 127.0.0.1");
  }
  handle_ = socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  const int yes = 1;
  setsockopt(handle_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  auto* raw = reinterpret_cast<sockaddr*>(&at);
  socklen_t size = sizeof at;
  if (handle_ < 0 || bind(handle_, raw, size) != 0 || listen(handle_, kBacklog) != 0 ||
      getsockname(handle_, raw, &size) != 0) {
    const std::string why = std::strerror(errno);
    if (handle_ >= 0) close(handle_);
    throw cannotListen(address, port, why);
  }
  port_ = ntohs(at.sin_port);
}

TcpListener::~TcpListener() { close(handle_); }

TcpListener::Accepted TcpListener::accept(int* handle) const {
  *handle = accept4(handle_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
  if (*handle < 0) {
    return errno == EMFILE || errno == ENFILE ? Accepted::no_room : Accepted::nobody;
  }
  const int yes = 1;
  setsockopt(*handle, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
  return isAmongTheLast(*handle) ? Accepted::few_left : Accepted::client;
}

}  // namespace vir::live
