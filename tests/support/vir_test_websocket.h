#pragma once
/// A WebSocket client that says and hears what a test wants; no library, so that the server's is
/// not tested against itself.
#include <arpa/inet.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <cstdint>
#include <optional>
#include <string>

namespace vir::test {

class WebsocketClient {
 public:
  explicit WebsocketClient(int port) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in at{};
    at.sin_family = AF_INET;
    at.sin_port = htons(static_cast<std::uint16_t>(port));
    at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    connected_ = ::connect(socket_, reinterpret_cast<sockaddr*>(&at), sizeof at) == 0;
    const timeval patience{5, 0};
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  }
  ~WebsocketClient() { ::close(socket_); }
  WebsocketClient(const WebsocketClient&) = delete;
  WebsocketClient& operator=(const WebsocketClient&) = delete;

  bool connected() const { return connected_; }

  /// The server's answer up to the empty line.
  std::string shakeHands(const std::string& protocol, const std::string& path = "/") {
    sendRaw("GET " + path +
            " HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n"
            "Sec-WebSocket-Protocol: " +
            protocol + "\r\n\r\n");
    while (received_.find("\r\n\r\n") == std::string::npos && receive()) {
    }
    const std::size_t end = received_.find("\r\n\r\n");
    const std::string head = received_.substr(0, end);
    received_.erase(0, end == std::string::npos ? end : end + 4);
    return head;
  }

  void sendRaw(const std::string& bytes) {
    if (::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL) < 0) connected_ = false;
  }
  /// A frame of text, below 64 kB, masked as a client's must be (with zeros).
  void sendText(const std::string& text) {
    std::string frame = "\x81";
    if (text.size() < 126) {
      frame += static_cast<char>(0x80 | text.size());
    } else {
      frame += static_cast<char>(0xFE);
      frame += static_cast<char>(text.size() >> 8);
      frame += static_cast<char>(text.size());
    }
    sendRaw(frame + std::string(4, '\0') + text);
  }

  struct Frame {
    int opcode = 0;  ///< 1 text, 2 binary, 8 end
    std::string payload;
  };
  /// The next frame; empty when the connection has ended or nothing comes for 5 s.
  std::optional<Frame> next() {
    if (!need(2)) return std::nullopt;
    std::uint64_t size = byte(1) & 0x7F;
    std::size_t head = 2;
    if (size >= 126) {
      const std::size_t wide = size == 126 ? 2 : 8;
      if (!need(2 + wide)) return std::nullopt;
      size = 0;
      for (std::size_t i = 0; i < wide; ++i) size = size << 8 | byte(2 + i);
      head += wide;
    }
    if (!need(head + size)) return std::nullopt;
    Frame frame{static_cast<int>(byte(0) & 0x0F), received_.substr(head, size)};
    received_.erase(0, head + size);
    return frame;
  }

 private:
  unsigned byte(std::size_t i) const { return static_cast<unsigned char>(received_[i]); }
  bool receive() {
    char buffer[4096];
    const ssize_t n = ::recv(socket_, buffer, sizeof buffer, 0);
    if (n > 0) received_.append(buffer, static_cast<std::size_t>(n));
    return n > 0;
  }
  bool need(std::size_t size) {
    while (received_.size() < size) {
      if (!receive()) return false;
    }
    return true;
  }

  int socket_;
  bool connected_ = false;
  std::string received_;
};

}  // namespace vir::test
