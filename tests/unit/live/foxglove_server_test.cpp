/// The WebSocket that Foxglove connects to: what it says, and who can harm it.
#include "vir/live/foxglove_server.h"

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>
#include <vector>

#include "vir/core/little_endian.h"
#include "vir_test_websocket.h"

namespace vir::live {
namespace {

using Json = nlohmann::json;
using test::WebsocketClient;

constexpr const char* kProtocol = "foxglove.websocket.v1";
constexpr const char* kLocal = "127.0.0.1";

FoxgloveServer::Channel channel(const std::string& topic, bool latched = false) {
  return {topic, "json", "test.Thing", "jsonschema", R"({"type":"object"})", latched};
}

/// The next message of text.
Json nextJson(WebsocketClient* client) {
  const auto frame = client->next();
  if (!frame || frame->opcode != 1) return Json();
  return Json::parse(frame->payload, nullptr, false);
}

template <typename Condition>
bool soon(Condition condition) {
  for (int i = 0; i < 500 && !condition(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return condition();
}

void subscribe(WebsocketClient* client, std::uint32_t id, std::uint32_t channel) {
  client->sendText(
      Json({{"op", "subscribe"}, {"subscriptions", {{{"id", id}, {"channelId", channel}}}}})
          .dump());
}

TEST(FoxgloveServer, SaysWhatThereIsAndSendsWhatIsAskedFor) {
  FoxgloveServer server(kLocal, 0);
  const std::uint32_t first = server.advertise(channel("/first"));
  WebsocketClient client(server.port());
  const std::string head = client.shakeHands(std::string("other.protocol, ") + kProtocol);
  EXPECT_EQ(head.rfind("HTTP/1.1 101", 0), 0u) << head;
  EXPECT_NE(head.find("s3pPLMBiTxaQ9kYGzzhZRbK+xOo="), std::string::npos) << "RFC 6455's example";
  EXPECT_NE(head.find(std::string("Sec-WebSocket-Protocol: ") + kProtocol), std::string::npos);
  EXPECT_EQ(nextJson(&client)["op"], "serverInfo");
  const Json told = nextJson(&client);
  EXPECT_EQ(told["op"], "advertise");
  ASSERT_EQ(told["channels"].size(), 1u);
  EXPECT_EQ(told["channels"][0]["topic"], "/first");
  EXPECT_EQ(told["channels"][0]["id"], first);

  const std::uint32_t later = server.advertise(channel("/later"));
  EXPECT_EQ(nextJson(&client)["channels"][0]["topic"], "/later");
  EXPECT_FALSE(server.wanted(later));
  subscribe(&client, 77, later);
  ASSERT_TRUE(soon([&] { return server.wanted(later); }));
  EXPECT_FALSE(server.wanted(first));
  server.send(first, 1, "nobody wants this");
  server.send(later, 1600000000123456789, R"({"x":1})");
  const auto data = client.next();
  ASSERT_TRUE(data);
  EXPECT_EQ(data->opcode, 2);
  ASSERT_GT(data->payload.size(), 13u);
  EXPECT_EQ(data->payload[0], 1);
  EXPECT_EQ(unsignedAt<4>(bytesOf(data->payload) + 1), 77u);
  EXPECT_EQ(unsignedAt<8>(bytesOf(data->payload) + 5), 1600000000123456789u);
  EXPECT_EQ(data->payload.substr(13), R"({"x":1})");

  client.sendText(R"({"op":"unsubscribe","subscriptionIds":[77]})");
  EXPECT_TRUE(soon([&] { return !server.wanted(later); }));
}

TEST(FoxgloveServer, WhoComesLateGetsTheLastOfWhatIsLatched) {
  FoxgloveServer server(kLocal, 0);
  const std::uint32_t fixed = server.advertise(channel("/fixed", true));
  server.send(fixed, 1, "old");
  server.send(fixed, 2, "new");
  WebsocketClient client(server.port());
  client.shakeHands(kProtocol);
  nextJson(&client);
  nextJson(&client);
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  subscribe(&client, 5, fixed);
  const auto data = client.next();
  ASSERT_TRUE(data);
  EXPECT_EQ(data->payload.substr(13), "new");
}

TEST(FoxgloveServer, ParametersCanBeRead) {
  FoxgloveServer server(kLocal, 0);
  server.setParameters({{"Window.keyframes", "14"}, {"Tracker.max_tracks", "150"}});
  WebsocketClient client(server.port());
  client.shakeHands(kProtocol);
  nextJson(&client);
  client.sendText(R"({"op":"getParameters","parameterNames":["Window.keyframes","no"],"id":"a"})");
  const Json some = nextJson(&client);
  EXPECT_EQ(some["id"], "a");
  ASSERT_EQ(some["parameters"].size(), 1u);
  EXPECT_EQ(some["parameters"][0]["value"], "14");
  client.sendText(R"({"op":"getParameters","parameterNames":[]})");
  EXPECT_EQ(nextJson(&client)["parameters"].size(), 2u);
}

TEST(FoxgloveServer, WhatIsNotUnderstoodIsSaidAndDoesNoHarm) {
  FoxgloveServer server(kLocal, 0);
  const std::uint32_t id = server.advertise(channel("/a"));
  WebsocketClient client(server.port());
  client.shakeHands(kProtocol);
  nextJson(&client);
  nextJson(&client);
  for (const char* request :
       {"", "{", "[]", "7", R"({"op":7})", R"({"op":"fly"})", R"({"op":"subscribe"})",
        R"({"op":"subscribe","subscriptions":[{"id":"x","channelId":1}]})",
        R"({"op":"subscribe","subscriptions":[{"id":1,"channelId":99}]})",
        R"({"op":"unsubscribe","subscriptionIds":[{}]})", R"({"op":"getParameters"})"}) {
    client.sendText(request);
    EXPECT_EQ(nextJson(&client)["op"], "status") << request;
  }
  client.sendText(R"({"op":"unsubscribe","subscriptionIds":[12345]})");
  subscribe(&client, 1, id);
  EXPECT_TRUE(soon([&] { return server.wanted(id); }));
}

TEST(FoxgloveServer, StrangersAreSentAway) {
  FoxgloveServerOptions options;
  options.token = "sesame";
  options.max_clients = 2;
  FoxgloveServer server(kLocal, 0, options);
  {
    WebsocketClient without(server.port()), wrong(server.port());
    EXPECT_NE(without.shakeHands(kProtocol).find("403"), std::string::npos);
    EXPECT_NE(wrong.shakeHands(kProtocol, "/?token=sesam").find("403"), std::string::npos);
  }
  ASSERT_TRUE(soon([&] { return server.refused() == 2; }));
  {
    WebsocketClient other(server.port());
    EXPECT_NE(other.shakeHands("chat", "/?token=sesame").find("400"), std::string::npos);
  }
  ASSERT_TRUE(soon([&] { return server.refused() == 3; }));
  WebsocketClient one(server.port()), two(server.port());
  EXPECT_NE(one.shakeHands(kProtocol, "/?token=sesame").find("101"), std::string::npos);
  EXPECT_NE(two.shakeHands(kProtocol, "/?token=sesame").find("101"), std::string::npos);
  WebsocketClient three(server.port());
  EXPECT_EQ(three.shakeHands(kProtocol, "/?token=sesame"), "");
  EXPECT_EQ(server.clients(), 2u);
}

TEST(FoxgloveServer, GarbageEndsTheConnectionOnly) {
  FoxgloveServer server(kLocal, 0);
  WebsocketClient noise(server.port());
  noise.sendRaw(std::string(100000, '\xA5'));
  WebsocketClient broken(server.port());
  broken.shakeHands(kProtocol);
  nextJson(&broken);
  broken.sendRaw(std::string("\x81\x05hello", 7));  // not masked
  const auto end = broken.next();
  EXPECT_TRUE(!end || end->opcode == 8);
  EXPECT_TRUE(soon([&] { return server.clients() == 0; }));
  WebsocketClient good(server.port());
  EXPECT_NE(good.shakeHands(kProtocol).find("101"), std::string::npos);
}

TEST(FoxgloveServer, ASlowClientLosesMessagesAndNobodyWaits) {
  FoxgloveServerOptions options;
  options.most_pending = 1 << 20;
  FoxgloveServer server(kLocal, 0, options);
  const std::uint32_t id = server.advertise(channel("/big"));
  WebsocketClient slow(server.port());
  slow.shakeHands(kProtocol);
  subscribe(&slow, 1, id);
  ASSERT_TRUE(soon([&] { return server.wanted(id); }));
  const auto started = std::chrono::steady_clock::now();
  for (int i = 0; i < 200; ++i) server.send(id, i, std::string(1 << 18, 'x'));
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - started;
#ifdef VIR_SANITIZED
  constexpr double kLongest_s = 20;
#else
  constexpr double kLongest_s = 2;
#endif
  EXPECT_LT(took.count(), kLongest_s);
  EXPECT_TRUE(soon([&] { return server.dropped() > 100; }));
}

TEST(FoxgloveServer, APortThatCannotBe) {
  FoxgloveServer server(kLocal, 0);
  EXPECT_THROW(FoxgloveServer(kLocal, server.port()), std::runtime_error);
  EXPECT_THROW(FoxgloveServer("nowhere", 0), std::runtime_error);
}

}  // namespace
}  // namespace vir::live
