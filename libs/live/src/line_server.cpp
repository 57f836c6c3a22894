#include "vir/live/line_server.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <utility>

#include "vir/core/resource_usage.h"

namespace vir::live {
namespace {

constexpr std::size_t kMostPending = 1 << 20;  // [byte]; about ten seconds of poses
constexpr int kAtOnce = 64;
constexpr int kLookEveryMs = 1000, kHearEveryMs = 20;
constexpr double kTokenWithinS = 5;
constexpr std::size_t kLongestToken = 1024;  // [byte]
constexpr std::chrono::milliseconds kPause{100};

/// In a time that does not tell where they differ.
bool same(const std::string& a, const std::string& b) {
  unsigned char differ = a.size() == b.size() ? 0 : 1;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    differ = static_cast<unsigned char>(differ | (a[i] ^ b[i]));
  }
  return differ == 0;
}

}  // namespace

LineServer::LineServer(const std::string& address, int port, LineServerOptions options)
    : options_(std::move(options)), listener_(address, port) {
  wake_ = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  thread_ = std::thread([this] { serve(); });
}

LineServer::~LineServer() {
  stop_ = true;
  const std::uint64_t one = 1;
  if (write(wake_, &one, sizeof one) < 0) stop_ = true;  // it looks by itself now and then
  thread_.join();
  for (const auto& [handle, client] : clients_) close(handle);
  close(wake_);
}

void LineServer::serve() {
  while (!stop_) {
    bool expecting = false;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      for (const auto& [handle, client] : clients_) expecting = expecting || !client.admitted;
    }
    pollfd ready[] = {{listener_.handle(), POLLIN, 0}, {wake_, POLLIN, 0}};
    poll(ready, 2, expecting ? kHearEveryMs : kLookEveryMs);
    if (stop_) return;
    bool room = true;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      room = acceptWaiting();
      hearNewcomers();
    }
    // Without descriptors the connections stay where they are: not to spin on them.
    if (!room) std::this_thread::sleep_for(kPause);
  }
}

void LineServer::refuse(int handle, const char* why) {
  const std::string line = std::string("{\"type\":\"refused\",\"why\":\"") + why + "\"}\n";
  if (::send(handle, line.data(), line.size(), MSG_NOSIGNAL | MSG_DONTWAIT) < 0) errno = 0;
  close(handle);
  ++refused_;
}

/// False if there is no descriptor left for another one.
bool LineServer::acceptWaiting() {
  for (int i = 0; i < kAtOnce; ++i) {
    int handle = -1;
    const TcpListener::Accepted accepted = listener_.accept(&handle);
    if (accepted == TcpListener::Accepted::no_room) return false;
    if (accepted == TcpListener::Accepted::nobody) return true;
    if (clients_.size() >= static_cast<std::size_t>(options_.max_clients)) {
      refuse(handle, "too many clients (Recording.stream_clients)");
      continue;
    }
    if (accepted == TcpListener::Accepted::few_left) {
      refuse(handle, "the program has few descriptors left (ulimit -n)");
      continue;
    }
    Client& client = clients_[handle];
    client.admitted = options_.token.empty();
    client.since_s = wallSeconds();
  }
  return true;
}

void LineServer::hearNewcomers() {
  for (auto it = clients_.begin(); it != clients_.end();) {
    const Hearing heard = it->second.admitted ? Hearing::admitted : hear(it->first, &it->second);
    it->second.admitted = heard == Hearing::admitted;
    if (heard == Hearing::refused) {
      refuse(it->first, "the first line must be the token (Recording.stream_token)");
      it = clients_.erase(it);
    } else {
      ++it;
    }
  }
}

LineServer::Hearing LineServer::hear(int handle, Client* client) const {
  char buffer[256];
  const ssize_t n = recv(handle, buffer, sizeof buffer, MSG_DONTWAIT);
  if (n == 0) return Hearing::refused;
  if (n > 0) client->said.append(buffer, static_cast<std::size_t>(n));
  const std::size_t end = client->said.find('\n');
  if (end == std::string::npos) {
    const bool late = wallSeconds() > client->since_s + kTokenWithinS;
    return late || client->said.size() > kLongestToken ? Hearing::refused : Hearing::waiting;
  }
  std::string said = client->said.substr(0, end);
  if (!said.empty() && said.back() == '\r') said.pop_back();
  client->said.clear();
  return same(said, options_.token) ? Hearing::admitted : Hearing::refused;
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
  acceptWaiting();  // who has just connected need not wait for the thread
  for (auto it = clients_.begin(); it != clients_.end();) {
    Client& client = it->second;
    if (!client.admitted) {
      ++it;
      continue;
    }
    client.to_send += line + "\n";
    const bool slow = client.to_send.size() > kMostPending;
    if (!slow && push(it->first, &client.to_send)) {
      ++it;
      continue;
    }
    close(it->first);
    it = clients_.erase(it);
  }
}

std::size_t LineServer::clients() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return static_cast<std::size_t>(std::count_if(clients_.begin(), clients_.end(),
                                                [](const auto& c) { return c.second.admitted; }));
}

long LineServer::refused() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return refused_;
}

}  // namespace vir::live
