#pragma once
/// One connection of a WebSocket server: the library keeps the protocol, the bytes go by hand, so
/// that nothing waits and every limit is ours.
#include <functional>
#include <string>
#include <websocketpp/config/core.hpp>
#include <websocketpp/server.hpp>

namespace vir::live {

using WebsocketEndpoint = websocketpp::server<websocketpp::config::core>;

/// One thread at a time.
class WebsocketClient {
 public:
  struct Hooks {
    /// May it come in? Chooses the subprotocol, or sets the status of the refusal.
    std::function<bool(WebsocketEndpoint::connection_type*)> admit;
    std::function<void()> opened;
    std::function<void(const std::string&)> heard;  ///< a message of text
  };
  /// `handle` is its own from now on.
  WebsocketClient(int handle, WebsocketEndpoint* endpoint, Hooks hooks);
  ~WebsocketClient();
  WebsocketClient(const WebsocketClient&) = delete;
  WebsocketClient& operator=(const WebsocketClient&) = delete;

  /// Takes what has arrived.
  void hear();
  /// Sends what the socket takes.
  void push();
  void sendText(const std::string& text);
  void sendBinary(const std::string& bytes);

  int handle() const { return handle_; }
  std::size_t pending() const { return to_send_.size(); }  ///< [byte]
  bool open() const { return open_; }
  /// Gone, or refused, and what was said to it has been sent.
  bool over() const { return ending_ && to_send_.empty(); }
  /// It has not said in time what it wants.
  bool late() const;

 private:
  int handle_;
  Hooks hooks_;
  WebsocketEndpoint::connection_ptr connection_;
  std::string to_send_;
  double since_s_;
  bool open_ = false, ending_ = false;
};

}  // namespace vir::live
