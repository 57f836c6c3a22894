/// What a node of ROS 2 sees, which knows nothing of our code.
#include "cyclone/ros_topics.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "program.h"
#include "vir_test_temp_folder.h"

namespace vir::dds {
namespace {

using Json = nlohmann::json;

/// The newest message of each topic, and the writers by their topics.
std::map<std::string, Json> newest(const std::string& text) {
  std::map<std::string, Json> out;
  std::istringstream lines(text.substr(0, text.rfind('\n') + 1));
  for (std::string line; std::getline(lines, line);) {
    const Json json = Json::parse(line);
    if (json.contains("topic")) out[json["topic"]] = json;
    if (json.contains("writer")) out[json["writer"]] = json;
  }
  return out;
}

TEST(RosTopics, AreSeenByAListenerOfRos2) {
  const test::TempFolder folder;
  const std::string out = (folder / "out").string();
  LinkOptions options;
  options.domain = test::ownDomain();
  const auto topics = openRosTopics(options);
  test::Program listener("vir_test_dds_ros_listener", {std::to_string(options.domain), "/robot1"},
                         out);
  StateEstimate e;
  e.state.t = 1'700'000'000'250'000'000;
  // A quarter of a turn about z: the body's x is the world's y.
  e.state.T_W_B = {Quat(rotZ(0.5 * M_PI)), Vec3(1, 2, 3)};
  e.state.v = Vec3(0, 4, 5);
  e.covariance.diagonal() << 0.5, 1, 2, 0.125, 0.25, 0.75;
  std::map<std::string, Json> seen;
  for (int i = 0; i < 200 && seen.size() < 6; ++i) {
    topics->odometry("/robot1/odometry", "robot1/world", "robot1/imu", e);
    topics->pose("/robot1/pose", "robot1/world", {e.state.t, e.state.T_W_B}, e.covariance);
    topics->transform("robot1/world", "robot1/imu", {e.state.t, e.state.T_W_B});
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    seen = newest(test::readText(out));
  }
  ASSERT_EQ(seen.size(), 6u) << test::readText(out);
  const Json odometry = seen["odometry"];
  EXPECT_EQ(odometry["s"], 1'700'000'000);
  EXPECT_EQ(odometry["ns"], 250'000'000);
  EXPECT_EQ(odometry["frame"], "robot1/world");
  EXPECT_EQ(odometry["child"], "robot1/imu");
  EXPECT_EQ(odometry["p"], Json({1.0, 2.0, 3.0}));
  EXPECT_NEAR(odometry["q"][2].get<double>(), std::sqrt(0.5), 1e-8);
  EXPECT_NEAR(odometry["q"][3].get<double>(), std::sqrt(0.5), 1e-8);
  EXPECT_NEAR(odometry["v"][0].get<double>(), 4, 1e-8) << "in the body";
  EXPECT_NEAR(odometry["v"][2].get<double>(), 5, 1e-8);
  // About the axes of the world: its x is the body's -y.
  EXPECT_NEAR(odometry["C"][0].get<double>(), 0.5, 1e-8);
  EXPECT_NEAR(odometry["C"][1].get<double>(), 0.25, 1e-8);
  EXPECT_NEAR(odometry["C"][2].get<double>(), 0.75, 1e-8);
  EXPECT_EQ(seen["pose"]["C"], odometry["C"]);
  EXPECT_EQ(seen["pose"]["p"], odometry["p"]);
  EXPECT_EQ(seen["tf"]["frame"], "robot1/world");
  EXPECT_EQ(seen["tf"]["child"], "robot1/imu");
  EXPECT_EQ(seen["tf"]["p"], odometry["p"]);
  EXPECT_EQ(seen["rt/robot1/odometry"]["type"], "nav_msgs::msg::dds_::Odometry_");
  EXPECT_EQ(seen["rt/robot1/pose"]["type"], "geometry_msgs::msg::dds_::PoseWithCovarianceStamped_");
  EXPECT_EQ(seen["rt/tf"]["type"], "tf2_msgs::msg::dds_::TFMessage_");
  EXPECT_EQ(seen["rt/robot1/odometry"]["user_data"],
            "typehash=RIHS01_3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0;");
}

}  // namespace
}  // namespace vir::dds
