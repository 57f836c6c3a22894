#include "vir/live/line_server.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

namespace vir::live {
namespace {

constexpr std::size_t kMostPending = 1 << 20;  // [byte]; about ten seconds of poses

std::runtime_error cannotListen(const std::string& address, int port, const std::string& why) {
  return std::runtime_error("cannot listen on " + address + ":" + std::to_string(port) + ": " +
                            why);
}

}  // namespace

LineServer::LineServer(const std::string& address, int port) {
  sockaddr_in at{};
  at.sin_family = AF_INET;
  at.sin_port = htons(static_cast<std::uint16_t>(port));
  if (inet_pton(AF_INET, address.c_str(), &at.sin_addr) != 1) {
    throw cannotListen(address, port, "not an IPv4 address, e.g. 127.0.0.1");
  }
  listening_ = socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  const int yes = 1;
  setsockopt(listening_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  auto* raw = reinterpret_cast<sockaddr*>(&at);
  socklen_t size = sizeof at;
  if (listening_ < 0 || bind(listening_, raw, size) != 0 || listen(listening_, 8) != 0 ||
      getsockname(listening_, raw, &size) != 0) {
    const std::string why = std::strerror(errno);
    if (listening_ >= 0) close(listening_);
    throw cannotListen(address, port, why);
  }
  port_ = ntohs(at.sin_port);
}

LineServer::~LineServer() {
  for (const auto& [client, pending] : clients_) close(client);
  close(listening_);
}

void LineServer::acceptWaiting() {
  while (true) {
    const int client = accept4(listening_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (client < 0) return;
    const int yes = 1;
    setsockopt(client, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
    clients_[client];
  }
}

/// False when the connection is gone.
bool LineServer::push(int client, std::string* pending) {
  while (!pending->empty()) {
    const ssize_t n = ::send(client, pending->data(), pending->size(), MSG_NOSIGNAL);
    if (n < 0) return errno == EAGAIN || errno == EINTR;
    pending->erase(0, static_cast<std::size_t>(n));
  }
  return true;
}

void LineServer::send(const std::string& line) {
  const std::lock_guard<std::mutex> lock(mutex_);
  acceptWaiting();
  for (auto it = clients_.begin(); it != clients_.end();) {
    it->second += line + "\n";
    const bool slow = it->second.size() > kMostPending;
    if (!slow && push(it->first, &it->second)) {
      ++it;
      continue;
    }
    cut_off_ += slow ? 1 : 0;
    close(it->first);
    it = clients_.erase(it);
  }
}

std::size_t LineServer::clients() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return clients_.size();
}

long LineServer::clientsCutOff() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return cut_off_;
}

}  // namespace vir::live
