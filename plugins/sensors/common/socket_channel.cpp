/// TCP connections and UDP datagrams as a stream of bytes.
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <optional>
#include <utility>

#include "byte_fd.h"
#include "byte_source.h"

namespace vir {
namespace {

struct Address {
  sockaddr_storage bytes{};
  socklen_t size = 0;
  int family = AF_INET;
  const sockaddr* get() const { return reinterpret_cast<const sockaddr*>(&bytes); }
};

Address resolve(const std::string& host, int port, int type, int flags) {
  addrinfo hints{};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = type;
  hints.ai_flags = flags | AI_NUMERICSERV;
  addrinfo* found = nullptr;
  const int error = ::getaddrinfo(host.empty() ? nullptr : host.c_str(),
                                  std::to_string(port).c_str(), &hints, &found);
  if (error != 0 || found == nullptr) {
    throw DeviceError(host + ": no such address: " + gai_strerror(error));
  }
  Address a;
  std::memcpy(&a.bytes, found->ai_addr, found->ai_addrlen);
  a.size = found->ai_addrlen;
  a.family = found->ai_family;
  ::freeaddrinfo(found);
  return a;
}

bool sameHost(const sockaddr_storage& a, const sockaddr_storage& b) {
  if (a.ss_family != b.ss_family) return false;
  if (a.ss_family == AF_INET6) {
    return std::memcmp(&reinterpret_cast<const sockaddr_in6&>(a).sin6_addr,
                       &reinterpret_cast<const sockaddr_in6&>(b).sin6_addr, sizeof(in6_addr)) == 0;
  }
  return reinterpret_cast<const sockaddr_in&>(a).sin_addr.s_addr ==
         reinterpret_cast<const sockaddr_in&>(b).sin_addr.s_addr;
}

bool wouldBlock(int error) { return error == EAGAIN || error == EWOULDBLOCK || error == EINTR; }

class TcpChannel : public ByteChannel {
 public:
  explicit TcpChannel(ByteFd fd) : fd_(std::move(fd)) {}

  long read(std::uint8_t* buffer, std::size_t size, std::string* why) override {
    if (!ready()) return failed(why) ? -1 : 0;
    if (size == 0) return 0;
    const ssize_t n = ::recv(fd_.get(), buffer, size, MSG_DONTWAIT);
    if (n > 0) return n;
    if (n < 0 && wouldBlock(errno)) return 0;
    *why = n == 0 ? "the other side closed the connection"
                  : std::string("the connection broke (") + std::strerror(errno) + ")";
    return -1;
  }
  bool write(const std::uint8_t* bytes, std::size_t size) override {
    return ready() && ::send(fd_.get(), bytes, size, MSG_DONTWAIT | MSG_NOSIGNAL) ==
                          static_cast<ssize_t>(size);
  }
  int fd() const override { return fd_.get(); }
  bool ready() override {
    if (ready_ || error_ != 0) return ready_;
    pollfd p{fd_.get(), POLLOUT, 0};
    if (::poll(&p, 1, 0) <= 0) return false;
    socklen_t size = sizeof error_;
    if (::getsockopt(fd_.get(), SOL_SOCKET, SO_ERROR, &error_, &size) != 0) error_ = errno;
    ready_ = error_ == 0;
    return ready_;
  }

 private:
  bool failed(std::string* why) {
    if (error_ == 0) return false;
    *why = std::string("cannot connect: ") + std::strerror(error_);
    return true;
  }

  ByteFd fd_;
  bool ready_ = false;
  int error_ = 0;
};

class TcpOpener : public ChannelOpener {
 public:
  TcpOpener(const std::string& host, int port)
      : name_(host + ":" + std::to_string(port)), address_(resolve(host, port, SOCK_STREAM, 0)) {}

  std::unique_ptr<ByteChannel> open() override {
    ByteFd fd(::socket(address_.family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
    const int yes = 1;
    if (fd.get() >= 0) {
      ::setsockopt(fd.get(), IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
      ::setsockopt(fd.get(), SOL_SOCKET, SO_KEEPALIVE, &yes, sizeof yes);
    }
    if (fd.get() < 0 ||
        (::connect(fd.get(), address_.get(), address_.size) != 0 && errno != EINPROGRESS)) {
      throw DeviceError(name_ + ": cannot connect: " + std::strerror(errno));
    }
    return std::make_unique<TcpChannel>(std::move(fd));
  }
  bool reopenWhenSilent() const override { return true; }

 private:
  std::string name_;
  Address address_;
};

class UdpChannel : public ByteChannel {
 public:
  UdpChannel(ByteFd fd, const std::optional<Address>& only) : fd_(std::move(fd)), only_(only) {}
  /// To one peer, whatever port it answers from.
  UdpChannel(ByteFd fd, const Address& peer)
      : fd_(std::move(fd)),
        only_(peer),
        peer_is_fixed_(true),
        sender_(peer.bytes),
        sender_size_(peer.size) {}

  long read(std::uint8_t* buffer, std::size_t size, std::string* why) override {
    if (size == 0) return 0;
    if (at_ == filled_ && !receive(why)) return why->empty() ? 0 : -1;
    const std::size_t n = std::min(size, filled_ - at_);
    std::memcpy(buffer, datagram_ + at_, n);
    at_ += n;
    return static_cast<long>(n);
  }
  bool write(const std::uint8_t* bytes, std::size_t size) override {
    if (sender_size_ == 0) return false;  // nobody to answer yet
    return ::sendto(fd_.get(), bytes, size, MSG_DONTWAIT, reinterpret_cast<sockaddr*>(&sender_),
                    sender_size_) == static_cast<ssize_t>(size);
  }
  int fd() const override { return fd_.get(); }

 private:
  bool receive(std::string* why) {
    sockaddr_storage from{};
    socklen_t from_size = sizeof from;
    const ssize_t n = ::recvfrom(fd_.get(), datagram_, sizeof datagram_, MSG_DONTWAIT,
                                 reinterpret_cast<sockaddr*>(&from), &from_size);
    at_ = filled_ = 0;
    if (n < 0) {
      // A refused answer of ours comes back as an error here; that is not the end.
      if (wouldBlock(errno) || errno == ECONNREFUSED) return false;
      *why = std::string("cannot receive (") + std::strerror(errno) + ")";
      return false;
    }
    if (only_ && !sameHost(from, only_->bytes)) return false;
    filled_ = static_cast<std::size_t>(n);
    if (!peer_is_fixed_) {
      sender_ = from;
      sender_size_ = from_size;
    }
    return filled_ > 0;
  }

  ByteFd fd_;
  std::optional<Address> only_;
  bool peer_is_fixed_ = false;
  std::uint8_t datagram_[65536];
  std::size_t at_ = 0, filled_ = 0;
  sockaddr_storage sender_{};
  socklen_t sender_size_ = 0;
};

class UdpOpener : public ChannelOpener {
 public:
  UdpOpener(const std::string& address, int port, const std::string& from)
      : name_("udp port " + std::to_string(port)),
        address_(resolve(address.empty() ? "127.0.0.1" : address, port, SOCK_DGRAM, AI_PASSIVE)) {
    if (!from.empty()) only_ = resolve(from, port, SOCK_DGRAM, 0);
  }

  std::unique_ptr<ByteChannel> open() override {
    ByteFd fd(::socket(address_.family, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
    if (fd.get() < 0 || ::bind(fd.get(), address_.get(), address_.size) != 0) {
      throw DeviceError(name_ + ": cannot listen: " + std::strerror(errno) +
                        (errno == EADDRINUSE ? " (another program listens there)" : ""));
    }
    return std::make_unique<UdpChannel>(std::move(fd), only_);
  }

 private:
  std::string name_;
  Address address_;
  std::optional<Address> only_;
};

class UdpPeerOpener : public ChannelOpener {
 public:
  UdpPeerOpener(const std::string& host, int port) : peer_(resolve(host, port, SOCK_DGRAM, 0)) {}

  std::unique_ptr<ByteChannel> open() override {
    ByteFd fd(::socket(peer_.family, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
    if (fd.get() < 0) throw DeviceError(std::string("udp: no socket: ") + std::strerror(errno));
    return std::make_unique<UdpChannel>(std::move(fd), peer_);
  }

 private:
  Address peer_;
};

}  // namespace

std::unique_ptr<ChannelOpener> udpPeerOpener(const std::string& host, int port) {
  return std::make_unique<UdpPeerOpener>(host, port);
}

std::unique_ptr<ChannelOpener> tcpOpener(const std::string& host, int port) {
  return std::make_unique<TcpOpener>(host, port);
}

std::unique_ptr<ChannelOpener> udpOpener(const std::string& address, int port,
                                         const std::string& from) {
  return std::make_unique<UdpOpener>(address, port, from);
}

}  // namespace vir
