#include "vir/live/foxglove_server.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <thread>

#include "vir/core/little_endian.h"
#include "vir/live/tcp_listener.h"
#include "websocket_client.h"

namespace vir::live {
namespace {

using Json = nlohmann::json;

constexpr const char* kProtocols[] = {"foxglove.websocket.v1", "foxglove.sdk.v1"};
constexpr char kMessageData = 1;  // opcode
constexpr int kLookEveryMs = 500, kAtOnce = 64;
constexpr std::size_t kMostWaiting = 32 << 20;  // [byte] not yet handed to clients
constexpr std::size_t kMostSubscriptions = 1000;

struct Message {
  std::uint32_t channel = 0;
  TimeNs t = 0;
  std::string bytes;
};

struct Client {
  std::unique_ptr<WebsocketClient> socket;
  std::map<std::uint32_t, std::uint32_t> subscription_of;  // by channel
};

std::string text(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Json channelJson(std::uint32_t id, const FoxgloveServer::Channel& c) {
  return {{"id", id},
          {"topic", c.topic},
          {"encoding", c.encoding},
          {"schemaName", c.schema_name},
          {"schemaEncoding", c.schema_encoding},
          {"schema", c.schema}};
}

}  // namespace

class FoxgloveServer::Impl {
 public:
  Impl(const std::string& address, int port, FoxgloveServerOptions options)
      : options_(std::move(options)), listener_(address, port) {
    endpoint_.clear_access_channels(websocketpp::log::alevel::all);
    endpoint_.clear_error_channels(websocketpp::log::elevel::all);
    wake_ = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    thread_ = std::thread([this] { serve(); });
  }

  ~Impl() {
    stop_ = true;
    wake();
    thread_.join();
    close(wake_);
  }

  std::uint32_t advertise(const Channel& channel) {
    std::uint32_t id = 0;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      channels_.push_back(channel);
      id = static_cast<std::uint32_t>(channels_.size());
      readers_.push_back(0);
    }
    wake();
    return id;
  }

  bool wanted(std::uint32_t channel) const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return channel >= 1 && channel <= readers_.size() && readers_[channel - 1] > 0;
  }

  void send(std::uint32_t channel, TimeNs t, std::string bytes) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (channel < 1 || channel > channels_.size()) return;
      if (readers_[channel - 1] == 0 && !channels_[channel - 1].latched) return;
      if (waiting_bytes_ > kMostWaiting) {
        ++dropped_;
        return;
      }
      waiting_bytes_ += bytes.size();
      waiting_.push_back({channel, t, std::move(bytes)});
    }
    wake();
  }

  void setParameters(FoxgloveParameters parameters) {
    const std::lock_guard<std::mutex> lock(mutex_);
    parameters_ = std::move(parameters);
  }

  int port() const { return listener_.port(); }
  std::size_t clients() const { return open_clients_; }
  long refused() const { return refused_; }
  long dropped() const { return dropped_; }

 private:
  void wake() const {
    const std::uint64_t one = 1;
    if (write(wake_, &one, sizeof one) < 0) return;  // it is awake, or looks by itself
  }

  void serve() {
    while (!stop_) {
      std::vector<pollfd> ready = {{listener_.handle(), POLLIN, 0}, {wake_, POLLIN, 0}};
      for (const auto& [handle, client] : clients_) {
        const short wish = client.socket->pending() == 0 ? POLLIN : POLLIN | POLLOUT;
        ready.push_back({handle, wish, 0});
      }
      poll(ready.data(), ready.size(), kLookEveryMs);
      std::uint64_t woken = 0;
      if (read(wake_, &woken, sizeof woken) < 0) woken = 0;
      if (stop_) return;
      acceptWaiting();
      for (auto& [handle, client] : clients_) client.socket->hear();
      advertiseNew();
      handOut();
      for (auto& [handle, client] : clients_) client.socket->push();
      dropEnded();
      countReaders();
    }
  }

  void acceptWaiting() {
    for (int i = 0; i < kAtOnce; ++i) {
      int handle = -1;
      const TcpListener::Accepted accepted = listener_.accept(&handle);
      if (accepted == TcpListener::Accepted::no_room) {
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
        return;
      }
      if (accepted == TcpListener::Accepted::nobody) return;
      const bool full = clients_.size() >= static_cast<std::size_t>(options_.max_clients);
      if (full || accepted == TcpListener::Accepted::few_left) {
        close(handle);
        ++refused_;
        continue;
      }
      welcome(handle);
    }
  }

  void welcome(int handle) {
    Client* client = &clients_[handle];  // a map's elements stay where they are
    client->socket = std::make_unique<WebsocketClient>(
        handle, &endpoint_,
        WebsocketClient::Hooks{
            [this](WebsocketEndpoint::connection_type* c) { return admit(c); },
            [this, client] { greet(client); },
            [this, client](const std::string& request) { answer(client, request); }});
  }

  bool admit(WebsocketEndpoint::connection_type* connection) {
    if (!options_.token.empty()) {
      const std::string& resource = connection->get_resource();
      const std::size_t query = resource.find('?');
      if (query == std::string::npos || resource.substr(query + 1) != "token=" + options_.token) {
        connection->set_status(websocketpp::http::status_code::forbidden);
        return false;
      }
    }
    const auto& offered = connection->get_requested_subprotocols();
    for (const char* known : kProtocols) {
      if (std::find(offered.begin(), offered.end(), known) == offered.end()) continue;
      connection->select_subprotocol(known);
      return true;
    }
    connection->set_status(websocketpp::http::status_code::bad_request);
    return false;
  }

  void greet(Client* client) {
    ++open_clients_;
    tell(client, {{"op", "serverInfo"},
                  {"name", options_.name},
                  {"capabilities", {"parameters"}},
                  {"supportedEncodings", Json::array()},
                  {"metadata", Json::object()}});
    const std::lock_guard<std::mutex> lock(mutex_);
    tellChannels(client, 0);
  }

  /// From the channel after `first` on; the mutex is held.
  void tellChannels(Client* client, std::size_t first) const {
    Json all = Json::array();
    for (std::size_t i = first; i < advertised_ && i < channels_.size(); ++i) {
      all.push_back(channelJson(static_cast<std::uint32_t>(i + 1), channels_[i]));
    }
    if (!all.empty()) tell(client, {{"op", "advertise"}, {"channels", all}});
  }

  void advertiseNew() {
    const std::lock_guard<std::mutex> lock(mutex_);
    const std::size_t first = advertised_;
    if (first == channels_.size()) return;
    advertised_ = channels_.size();
    for (auto& [handle, client] : clients_) {
      if (client.socket->open()) tellChannels(&client, first);
    }
  }

  static void tell(Client* client, const Json& json) { client->socket->sendText(text(json)); }

  static void complain(Client* client, const std::string& what) {
    tell(client, {{"op", "status"}, {"level", 2}, {"message", what}});
  }

  void answer(Client* client, const std::string& request) {
    const Json json = Json::parse(request, nullptr, false);
    if (!json.is_object() || !json.contains("op") || !json["op"].is_string()) {
      return complain(client, "not understood: expected an object with \"op\"");
    }
    try {
      const std::string op = json["op"];
      if (op == "subscribe") return subscribe(client, json);
      if (op == "unsubscribe") return unsubscribe(client, json);
      if (op == "getParameters") return tellParameters(client, json);
      complain(client, "this server does not know the operation " + op);
    } catch (const Json::exception&) {
      complain(client, "not understood: a field is missing or of another type");
    }
  }

  void subscribe(Client* client, const Json& json) {
    for (const Json& s : json.at("subscriptions")) {
      const auto id = s.at("id").get<std::uint32_t>();
      const auto channel = s.at("channelId").get<std::uint32_t>();
      std::optional<Message> last;
      {
        const std::lock_guard<std::mutex> lock(mutex_);
        if (channel < 1 || channel > channels_.size()) {
          complain(client, "there is no channel " + std::to_string(channel));
          continue;
        }
        if (client->subscription_of.size() >= kMostSubscriptions) continue;
        client->subscription_of[channel] = id;
        const auto found = latched_.find(channel);
        if (found != latched_.end()) last = found->second;
      }
      if (last) give(client, *last);
    }
  }

  static void unsubscribe(Client* client, const Json& json) {
    for (const Json& s : json.at("subscriptionIds")) {
      const auto id = s.get<std::uint32_t>();
      auto& all = client->subscription_of;
      const auto found = std::find_if(all.begin(), all.end(),
                                      [id](const auto& entry) { return entry.second == id; });
      if (found != all.end()) all.erase(found);
    }
  }

  void tellParameters(Client* client, const Json& json) const {
    const auto names = json.at("parameterNames").get<std::vector<std::string>>();
    Json found = Json::array();
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      for (const auto& [name, value] : parameters_) {
        const bool asked =
            names.empty() || std::find(names.begin(), names.end(), name) != names.end();
        if (asked) found.push_back({{"name", name}, {"value", value}});
      }
    }
    Json reply = {{"op", "parameterValues"}, {"parameters", found}};
    if (json.contains("id") && json["id"].is_string()) reply["id"] = json["id"];
    tell(client, reply);
  }

  void give(Client* client, const Message& m) {
    const auto subscription = client->subscription_of.find(m.channel);
    if (subscription == client->subscription_of.end()) return;
    if (client->socket->pending() > options_.most_pending) {
      ++dropped_;
      return;
    }
    std::string payload(1, kMessageData);
    put(&payload, subscription->second, 4);
    put(&payload, static_cast<std::uint64_t>(m.t), 8);
    payload += m.bytes;
    client->socket->sendBinary(payload);
  }

  void handOut() {
    std::vector<Message> messages;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      messages.swap(waiting_);
      waiting_bytes_ = 0;
    }
    for (const Message& m : messages) {
      for (auto& [handle, client] : clients_) {
        if (client.socket->open()) give(&client, m);
      }
    }
    const std::lock_guard<std::mutex> lock(mutex_);
    for (Message& m : messages) {
      if (channels_[m.channel - 1].latched) latched_[m.channel] = std::move(m);
    }
  }

  void dropEnded() {
    for (auto it = clients_.begin(); it != clients_.end();) {
      const WebsocketClient& socket = *it->second.socket;
      if (!socket.late() && !socket.over()) {
        ++it;
        continue;
      }
      if (socket.open()) {
        --open_clients_;
      } else {
        ++refused_;
      }
      it = clients_.erase(it);
    }
  }

  void countReaders() {
    const std::lock_guard<std::mutex> lock(mutex_);
    std::fill(readers_.begin(), readers_.end(), 0);
    for (const auto& [handle, client] : clients_) {
      for (const auto& [channel, id] : client.subscription_of) ++readers_[channel - 1];
    }
  }

  const FoxgloveServerOptions options_;
  const TcpListener listener_;
  int wake_ = -1;
  WebsocketEndpoint endpoint_;
  std::map<int, Client> clients_;             // of the thread
  std::map<std::uint32_t, Message> latched_;  // of the thread
  std::atomic<std::size_t> open_clients_{0};
  std::atomic<long> refused_{0}, dropped_{0};

  mutable std::mutex mutex_;  // of what follows
  std::vector<Channel> channels_;
  std::vector<int> readers_;  // of each channel
  std::size_t advertised_ = 0;
  std::vector<Message> waiting_;
  std::size_t waiting_bytes_ = 0;
  FoxgloveParameters parameters_;

  std::atomic<bool> stop_{false};
  std::thread thread_;
};

FoxgloveServer::FoxgloveServer(const std::string& address, int port, FoxgloveServerOptions options)
    : impl_(std::make_unique<Impl>(address, port, std::move(options))) {}
FoxgloveServer::~FoxgloveServer() = default;

std::uint32_t FoxgloveServer::advertise(const Channel& channel) {
  return impl_->advertise(channel);
}
bool FoxgloveServer::wanted(std::uint32_t channel) const { return impl_->wanted(channel); }
void FoxgloveServer::send(std::uint32_t channel, TimeNs t, std::string message) {
  impl_->send(channel, t, std::move(message));
}
void FoxgloveServer::setParameters(FoxgloveParameters parameters) {
  impl_->setParameters(std::move(parameters));
}
int FoxgloveServer::port() const { return impl_->port(); }
std::size_t FoxgloveServer::clients() const { return impl_->clients(); }
long FoxgloveServer::refused() const { return impl_->refused(); }
long FoxgloveServer::dropped() const { return impl_->dropped(); }

}  // namespace vir::live
