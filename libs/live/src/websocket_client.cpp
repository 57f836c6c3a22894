#include "websocket_client.h"

#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

#include "vir/core/resource_usage.h"

namespace vir::live {
namespace {

constexpr double kHandshakeWithinS = 5;
constexpr std::size_t kLongestRequest = 1 << 16;  // [byte]

}  // namespace

WebsocketClient::WebsocketClient(int handle, WebsocketEndpoint* endpoint, Hooks hooks)
    : handle_(handle),
      hooks_(std::move(hooks)),
      connection_(endpoint->get_connection()),
      since_s_(wallSeconds()) {
  using websocketpp::connection_hdl;
  connection_->set_max_message_size(kLongestRequest);
  connection_->set_write_handler([this](connection_hdl, const char* bytes, std::size_t size) {
    to_send_.append(bytes, size);
    return websocketpp::lib::error_code();
  });
  connection_->set_shutdown_handler([this](connection_hdl) {
    ending_ = true;
    return websocketpp::lib::error_code();
  });
  connection_->set_validate_handler(
      [this](connection_hdl) { return hooks_.admit(connection_.get()); });
  connection_->set_open_handler([this](connection_hdl) {
    open_ = true;
    hooks_.opened();
  });
  connection_->set_message_handler(
      [this](connection_hdl, const WebsocketEndpoint::message_ptr& message) {
        if (message->get_opcode() == websocketpp::frame::opcode::text) {
          hooks_.heard(message->get_payload());
        }
      });
  connection_->set_fail_handler([this](connection_hdl) { ending_ = true; });
  connection_->start();
}

WebsocketClient::~WebsocketClient() { close(handle_); }

void WebsocketClient::hear() {
  char buffer[4096];
  const ssize_t n = recv(handle_, buffer, sizeof buffer, MSG_DONTWAIT);
  if (n > 0) {
    connection_->read_all(buffer, static_cast<std::size_t>(n));
  } else if (n == 0 || (errno != EAGAIN && errno != EINTR)) {
    connection_->eof();
    to_send_.clear();
    ending_ = true;
  }
}

void WebsocketClient::push() {
  std::size_t done = 0;
  while (done < to_send_.size()) {
    const ssize_t n = ::send(handle_, to_send_.data() + done, to_send_.size() - done,
                             MSG_NOSIGNAL | MSG_DONTWAIT);
    if (n < 0) {
      if (errno == EAGAIN || errno == EINTR) break;
      ending_ = true;
      done = to_send_.size();
      break;
    }
    done += static_cast<std::size_t>(n);
  }
  to_send_.erase(0, done);
}

void WebsocketClient::sendText(const std::string& text) {
  connection_->send(text, websocketpp::frame::opcode::text);
}

void WebsocketClient::sendBinary(const std::string& bytes) {
  connection_->send(bytes, websocketpp::frame::opcode::binary);
}

bool WebsocketClient::late() const {
  return !open_ && wallSeconds() > since_s_ + kHandshakeWithinS;
}

}  // namespace vir::live
