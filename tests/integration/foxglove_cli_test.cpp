/// vir-slam run --foxglove with somebody who looks.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>

#include "vir/core/little_endian.h"
#include "vir_test_free_port.h"
#include "vir_test_paths.h"
#include "vir_test_shell.h"
#include "vir_test_temp_folder.h"
#include "vir_test_websocket.h"

namespace vir {
namespace {

using Json = nlohmann::json;
using test::contains;
using test::quoted;

/// Asks for everything and keeps the last message of each topic until the connection ends.
class Viewer {
 public:
  explicit Viewer(int port) : thread_([this, port] { look(port); }) {}
  void join() { thread_.join(); }

  std::map<std::string, long> count;
  std::map<std::string, std::string> last, schema;

 private:
  void look(int port) {
    std::unique_ptr<test::WebsocketClient> client;
    for (int i = 0; i < 600 && (!client || !client->connected()); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      client = std::make_unique<test::WebsocketClient>(port);
    }
    client->shakeHands("foxglove.websocket.v1");
    std::map<unsigned, std::string> topic_of;
    while (const auto frame = client->next()) {
      if (frame->opcode == 8) break;
      if (frame->opcode == 2) {
        const std::string& topic =
            topic_of[static_cast<unsigned>(unsignedAt<4>(bytesOf(frame->payload) + 1))];
        ++count[topic];
        last[topic] = frame->payload.substr(13);
        continue;
      }
      const Json told = Json::parse(frame->payload);
      if (told["op"] != "advertise") continue;
      for (const Json& c : told["channels"]) {
        const unsigned id = c["id"];
        topic_of[id] = c["topic"];
        schema[c["topic"]] = c["schemaName"];
        client->sendText(
            Json({{"op", "subscribe"}, {"subscriptions", {{{"id", id}, {"channelId", id}}}}})
                .dump());
      }
    }
  }
  std::thread thread_;
};

TEST(FoxgloveCli, ARunIsSeenWhileItGoesOn) {
  const test::TempFolder folder;
  const int port = test::freePort();
  Viewer viewer(port);
  const test::Outcome outcome = test::virSlam(
      "run " + quoted(test::sourceDir() + "/rawlog/two_A.rawlog") + " --out " +
      quoted((folder / "run").string()) +
      " --foxglove --set Foxglove.speed=8 --set Foxglove.port=" + std::to_string(port));
  viewer.join();
  EXPECT_EQ(outcome.code, 0) << outcome.text;
  EXPECT_TRUE(contains(outcome.text, "ws://localhost:" + std::to_string(port))) << outcome.text;
  EXPECT_GE(viewer.count["/health"], 400);
  EXPECT_GE(viewer.count["/odometry"], 400);
  EXPECT_GE(viewer.count["/cam0/tracks"], 400);
  EXPECT_GE(viewer.count["/range_residuals"], 100);
  EXPECT_GE(viewer.count["/imu0"], 4000);
  for (const char* topic : {"/tf", "/tf_static", "/path", "/anchors", "/landmarks", "/uwb0", "/log",
                            "/cam0/camera_info", "/cam0/image_raw/compressed"}) {
    EXPECT_GE(viewer.count[topic], 1) << topic;
  }
  EXPECT_EQ(viewer.schema["/anchors"], "visualization_msgs/msg/MarkerArray");
  EXPECT_EQ(viewer.schema["/cam0/tracks"], "foxglove.ImageAnnotations");
  const Json health = Json::parse(viewer.last["/health"]);
  EXPECT_EQ(health["health"], "ok");
  EXPECT_GT(health["sigma_x_m"].get<double>(), 0);
  EXPECT_LT(health["sigma_x_m"].get<double>(), 0.2);
  EXPECT_GE(Json::parse(viewer.last["/cam0/tracks"])["points"][0]["points"].size(), 30u);
  EXPECT_TRUE(contains(viewer.last["/cam0/image_raw/compressed"], "\xff\xd8\xff")) << "a JPEG";
}

TEST(FoxgloveCli, TheAuthorsOfTheProtocolReadOurs) {
  const std::string needed =
      "require('@foxglove/ws-protocol');require('@foxglove/rosmsg');require('ws');"
      "require('@foxglove/rosmsg2-serialization')";
  const bool there = test::shell("node -e \"" + needed + "\"").code == 0;
  if (!there) {
    GTEST_SKIP() << "node with @foxglove/ws-protocol, @foxglove/rosmsg, "
                    "@foxglove/rosmsg2-serialization and ws is not here (npm install, NODE_PATH)";
  }
  const test::TempFolder folder;
  const std::string port = std::to_string(test::freePort()), log = (folder / "log").string();
  const test::Outcome outcome =
      test::shell("node " + quoted(test::sourceDir() + "/tests/fixtures/foxglove/look.cjs") +
                  " ws://127.0.0.1:" + port + " & " + quoted(test::buildDir() + "/bin/vir-slam") +
                  " run " + quoted(test::sourceDir() + "/rawlog/two_A.rawlog") + " --out " +
                  quoted((folder / "run").string()) +
                  " --foxglove --set Foxglove.speed=8 --set Foxglove.port=" + port + " >" +
                  quoted(log) + " 2>&1; wait");
  const Json counts = Json::parse(outcome.text, nullptr, false);
  ASSERT_TRUE(counts.is_object()) << outcome.text;
  EXPECT_GE(counts.value("parameters", 0), 50);
  EXPECT_EQ(counts.value("complaints", 0), 0);
  EXPECT_GE(counts.value("/odometry", 0), 400);
  EXPECT_GE(counts.value("/imu0", 0), 4000);
  for (const char* topic : {"/health", "/cam0/tracks", "/anchors", "/landmarks", "/path", "/tf",
                            "/range_residuals", "/cam0/image_raw/compressed"}) {
    EXPECT_GE(counts.value(topic, 0), 1) << topic;
  }
}

TEST(FoxgloveCli, APortThatIsTakenIsSaid) {
  const test::TempFolder folder;
  const int port = test::freePort();
  const int other = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in at{};
  at.sin_family = AF_INET;
  at.sin_port = htons(static_cast<std::uint16_t>(port));
  at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  ASSERT_EQ(::bind(other, reinterpret_cast<sockaddr*>(&at), sizeof at), 0);
  ASSERT_EQ(::listen(other, 1), 0);
  const test::Outcome outcome =
      test::virSlam("run " + quoted(test::sourceDir() + "/rawlog/two_A.rawlog") + " --out " +
                    quoted((folder / "run").string()) +
                    " --foxglove --set Foxglove.port=" + std::to_string(port));
  ::close(other);
  EXPECT_EQ(outcome.code, 1);
  EXPECT_TRUE(contains(outcome.text, "cannot listen on 127.0.0.1:" + std::to_string(port)))
      << outcome.text;
}

}  // namespace
}  // namespace vir
