/// Two robots that meet live: each a process of its own with its sensors played and its radio
/// emulated, over DDS on this machine.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>
#include <vector>

#include "robot_truth.h"
#include "vir_test_free_port.h"
#include "vir_test_paths.h"
#include "vir_test_process.h"

namespace vir {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using test::contains;
using test::quoted;
using test::readJson;

void pause(double s) { std::this_thread::sleep_for(std::chrono::duration<double>(s)); }

double now() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

/// Tests of other checkouts may run at the same time.
std::string domain() { return std::to_string(1 + getpid() % 100); }
std::string team(const std::string& name) { return name + std::to_string(getpid()); }

/// The lines of `Recording.stream_port`.
class Stream {
 public:
  explicit Stream(int port) {
    sockaddr_in at{};
    at.sin_family = AF_INET;
    at.sin_port = htons(static_cast<std::uint16_t>(port));
    at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    for (int i = 0; i < 400; ++i) {
      handle_ = socket(AF_INET, SOCK_STREAM, 0);
      if (connect(handle_, reinterpret_cast<sockaddr*>(&at), sizeof at) == 0) return;
      close(handle_);
      handle_ = -1;
      pause(0.05);
    }
  }
  ~Stream() {
    if (handle_ >= 0) close(handle_);
  }
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;

  /// Reads until another robot has this status; null if it does not in time.
  Json peerThatIs(const std::string& status, double most_s) {
    const double end = now() + most_s;
    while (now() < end) {
      const Json line = next(end);
      if (line.is_null()) break;
      if (line["type"] == "peer" && line["status"] == status) return line;
    }
    return nullptr;
  }
  /// Reads until the map of the team has so many robots; null if it does not in time.
  Json teamOf(std::size_t robots, double most_s) {
    const double end = now() + most_s;
    while (now() < end) {
      const Json line = next(end);
      if (line.is_null()) break;
      if (line["type"] == "team" && line["robots"].size() == robots) return line;
    }
    return nullptr;
  }

 private:
  Json next(double end) {
    while (now() < end) {
      const std::size_t stop = text_.find('\n');
      if (stop != std::string::npos) {
        Json line = Json::parse(text_.substr(0, stop));
        text_.erase(0, stop + 1);
        return line;
      }
      char buffer[65536];
      const ssize_t n = recv(handle_, buffer, sizeof buffer, 0);
      if (n <= 0) break;
      text_.append(buffer, static_cast<std::size_t>(n));
    }
    return nullptr;
  }
  int handle_ = -1;
  std::string text_;
};

struct Robot {
  std::string name;
  int number = 0, other = 0, port = 0;
  std::string team;
  std::string sample() const { return test::sourceDir() + "/rawlog/two_" + name + ".rawlog"; }
};

class TeamLive : public testing::Test {
 protected:
  TeamLive() {
    if (!fs::exists(test::buildDir() + "/lib/vir-slam/libvir_dds_module.so")) return;
    start_s_ = static_cast<long>(now()) + 6;
    have_dds_ = true;
  }
  void SetUp() override {
    if (!have_dds_) GTEST_SKIP() << "built without DDS (cyclonedds-dev)";
  }
  std::string at(const std::string& name) const { return (folder_ / name).string(); }

  /// Its radio, plugged in for as long as the test lasts.
  void plugInRadio(const Robot& robot) {
    const std::string call = "exec " + quoted(test::buildDir() + "/bin/vir-device-emulator") + " " +
                             quoted(robot.sample()) + " --range-labels PEER --no-wait --start-at " +
                             std::to_string(start_s_) + " --uwb json=" + at("radio_" + robot.name) +
                             " > /dev/null 2>&1";
    helpers_.push_back(fork());
    if (helpers_.back() == 0) {
      execl("/bin/sh", "sh", "-c", call.c_str(), nullptr);
      _exit(127);
    }
    for (int i = 0; i < 200 && !fs::exists(at("radio_" + robot.name)); ++i) pause(0.05);
  }
  void startRelay(const std::string& a, const std::string& b, const char* lost, const char* delay_s,
                  const char* twice) {
    // Of this process, not of the child.
    const std::string program = test::buildDir() + "/bin/vir_test_dds_relay", number = domain();
    helpers_.push_back(fork());
    if (helpers_.back() == 0) {
      execl(program.c_str(), program.c_str(), number.c_str(), lost, delay_s, twice, a.c_str(),
            b.c_str(), nullptr);
      _exit(127);
    }
  }
  void TearDown() override {
    for (const pid_t pid : helpers_) {
      kill(pid, SIGKILL);
      waitpid(pid, nullptr, 0);
    }
  }

  std::string iniOf(const Robot& robot) const {
    std::string text = "[Recording]\nestimate = true\n[Estimator]\ndriver = vir\n";
    for (const auto& [section, label] : std::map<std::string, std::string>{
             {"camera", "CAM0"}, {"inertial", "IMU0"}, {"radio", "UWB0"}, {"truth", "GT"}}) {
      text += "[" + section +
              "]\ndriver = RawlogReplay\nprocess_rate = 200\nrawlog = " + robot.sample() +
              "\nlabels = " + label +
              "\nclock = keep\nstamps = now\nstart_at_s = " + std::to_string(start_s_) + "\n";
    }
    text +=
        "[mates]\ndriver = UwbSerial\nprocess_rate = 500\nsensorLabel = MATES\n"
        "protocol = json\nantenna_m = 0.03 0 0.08\nstd_error_m = 0.06\npeer_ids = " +
        std::to_string(robot.other) + "\nport = " + at("radio_" + robot.name) + "\n";
    return text + "[Dds]\nrobot = " + std::to_string(robot.number) + "\ndomain = " + domain() +
           "\nteam = " + robot.team + "\n";
  }
  /// `life`: a name for its files.
  std::unique_ptr<test::Process> start(const Robot& robot, const std::string& life) const {
    const std::string ini = at(life + ".ini");
    test::writeText(ini, iniOf(robot));
    std::vector<std::string> arguments{
        "record",    ini,      "--out", at(life + ".rawlog"),
        "--results", at(life), "--set", "Recording.stream_port=" + std::to_string(robot.port)};
    return std::make_unique<test::Process>(arguments);
  }
  /// Ends it as a user does.
  static void end(test::Process* robot) {
    robot->send(SIGINT);
    EXPECT_EQ(robot->wait(), 0) << robot->text();
  }
  double playedS() const { return now() - static_cast<double>(start_s_); }

  /// Of results, by the truth in a recording.
  Pose worldOf(const std::string& results, const std::string& rawlog) const {
    std::ifstream in(at(results + "/trajectory.tum"));
    evaluation::ReadReport report;
    return test::worldOf(test::truthIn(at(rawlog + ".rawlog")), evaluation::readTum(in, &report));
  }
  /// What `life` of a robot found in the end, against where both truly were.
  void expectTransform(const std::string& life, const std::string& other_life,
                       double most_m = 0.4) const {
    expectTransform(life, other_life, life, most_m);
  }
  void expectTransform(const std::string& life, const std::string& other_life,
                       const std::string& rawlog, double most_m) const {
    const Json t = readJson(folder_ / life / "transforms.json")["transforms"][0];
    ASSERT_EQ(t["status"], "unique") << t;
    const test::Deviation d =
        test::deviation(t, worldOf(life, rawlog).inverse() * worldOf(other_life, other_life));
    std::printf("%s: offset off by %.3f m, yaw by %.2f deg\n", life.c_str(), d.offset_m, d.yaw_deg);
    EXPECT_LT(d.offset_m, most_m);
    EXPECT_LT(d.yaw_deg, 4);
  }

  long start_s_ = 0;
  bool have_dds_ = false;
  test::TempFolder folder_;
  std::vector<pid_t> helpers_;
};

TEST_F(TeamLive, TheyMeetWithinTwentySeconds) {
  const Robot a{"A", 0, 1, test::freePort(), team("t")}, b{"B", 1, 0, test::freePort(), team("t")};
  plugInRadio(a);
  plugInRadio(b);
  const auto first = start(a, "a"), second = start(b, "b");
  Stream from_a(a.port), from_b(b.port);
  const Json b_in_a = from_a.peerThatIs("unique", 26), a_in_b = from_b.peerThatIs("unique", 10);
  std::printf("placed %.1f s after the recording began\n", playedS());
  EXPECT_LT(playedS(), 20);
  ASSERT_FALSE(b_in_a.is_null());
  ASSERT_FALSE(a_in_b.is_null());
  EXPECT_EQ(b_in_a["id"], 1);
  EXPECT_EQ(a_in_b["id"], 0);
  for (const Json& peer : {b_in_a, a_in_b}) {
    ASSERT_FALSE(peer["p"].is_null()) << peer;
    for (int i = 0; i < 3; ++i) EXPECT_LT(peer["sigma_p"][i].get<double>(), 1) << peer;
    EXPECT_LT(peer["t_ns"].get<std::int64_t>() - peer["told_t_ns"].get<std::int64_t>(), 1e9);
  }
  EXPECT_FALSE(from_a.teamOf(2, 5).is_null());
  pause(std::max(0.0, 12 - playedS()));
  end(first.get());
  end(second.get());
  expectTransform("a", "b");
  expectTransform("b", "a");
  // Both have one map of who is where, in the frame of the lower number.
  const Json map_a = readJson(folder_ / "a" / "team.json");
  const Json map_b = readJson(folder_ / "b" / "team.json");
  EXPECT_EQ(map_a["frame"], map_b["frame"]);
  EXPECT_EQ(map_a["frame"]["robot"], 0);
  for (const Json& map : {map_a, map_b}) {
    ASSERT_EQ(map["robots"].size(), 2u) << map;
    EXPECT_EQ(map["robots"][1]["id"], 1);
    ASSERT_FALSE(map["robots"][1]["p"].is_null()) << map;
  }
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(map_a["robots"][0]["t"][i].get<double>(), 0, 1e-9) << "its own world";
    EXPECT_NEAR(map_a["robots"][1]["t"][i].get<double>(), map_b["robots"][1]["t"][i].get<double>(),
                0.3);
  }
  const Json counters = readJson(folder_ / "a" / "summary.json")["counters"];
  EXPECT_GT(counters["team_accepted"], 50) << counters;
  // What was heard is recorded: the same is found from the file alone.
  const test::Outcome again =
      test::virSlam("run " + quoted(at("a/used.ini")) + " --rawlog " + quoted(at("a.rawlog")) +
                    " --out " + quoted(at("again")));
  EXPECT_EQ(again.code, 0) << again.text;
  expectTransform("again", "b", "a", 0.4);
}

TEST_F(TeamLive, ARobotThatIsKilledAndStartedAgainIsFoundAgain) {
  const Robot a{"A", 0, 1, test::freePort(), team("t")}, b{"B", 1, 0, test::freePort(), team("t")};
  plugInRadio(a);
  plugInRadio(b);
  const auto first = start(a, "a");
  auto second = start(b, "b");
  Stream from_a(a.port);
  ASSERT_FALSE(from_a.peerThatIs("unique", 26).is_null());
  const double killed_s = playedS();
  second->send(SIGKILL);
  EXPECT_EQ(second->wait(), -SIGKILL);
  second = start(b, "b2");
  const Json lost = from_a.peerThatIs("degenerate", 15);
  ASSERT_FALSE(lost.is_null());
  EXPECT_EQ(lost["reason"], "it began a new world");
  ASSERT_FALSE(from_a.peerThatIs("unique", 25).is_null());
  std::printf("killed at %.1f s, found again at %.1f s\n", killed_s, playedS());
  EXPECT_LT(playedS() - killed_s, 20);
  pause(std::max(0.0, 26 - playedS()));
  end(first.get());
  end(second.get());
  // It started on the way; its old world is metres off.
  expectTransform("a", "b2", 0.8);
  expectTransform("b2", "a", 0.8);
}

TEST_F(TeamLive, OverABadNetwork) {
  const Robot a{"A", 0, 1, test::freePort(), team("a")}, b{"B", 1, 0, test::freePort(), team("b")};
  startRelay(a.team, b.team, "0.3", "1", "0.2");
  plugInRadio(a);
  plugInRadio(b);
  const auto first = start(a, "a"), second = start(b, "b");
  Stream from_a(a.port);
  ASSERT_FALSE(from_a.peerThatIs("unique", 26).is_null());
  std::printf("placed %.1f s after the recording began\n", playedS());
  EXPECT_LT(playedS(), 20);
  pause(std::max(0.0, 14 - playedS()));
  end(first.get());
  end(second.get());
  expectTransform("a", "b");
  const Json counters = readJson(folder_ / "a" / "summary.json")["counters"];
  std::printf("%s\n", counters.dump().c_str());
  EXPECT_GT(counters["team_lost"], 20);
  EXPECT_GT(counters["team_repeated"], 5);
  EXPECT_GT(counters["team_reordered"], 20);
}

/// Odometry and ranges of three simulated robots: one map of who is where, by who meets whom.
TEST_F(TeamLive, ThreeProcessesHaveOneMap) {
  std::string world =
      "[simulator]\nrobots = A B C\nimages = none\nodometry = true\ngt_rate_hz = 20\n"
      "[Flight]\nlength_m = 30\nspeed_mps = 0.9\nrest_s = 1\n";
  const char* const where[] = {"eight\nstart_m = 0 0 0.3", "letter_s\nstart_m = 3 0 0.3",
                               "helix\nstart_m = 0 3 0.3"};
  for (int i = 0; i < 3; ++i) {
    world +=
        std::string("[Robot_") + char('A' + i) + "]\nduration_s = 28\nflight = " + where[i] + "\n";
  }
  test::writeText(at("world.ini"), world);
  const test::Outcome made =
      test::virSlam("simulate " + quoted(at("world.ini")) + " --out " + quoted(at("three.rawlog")));
  ASSERT_EQ(made.code, 0) << made.text;
  start_s_ = static_cast<long>(now()) + 4;
  std::vector<std::unique_ptr<test::Process>> robots;
  for (int i = 0; i < 3; ++i) {
    const std::string name(1, char('a' + i));
    test::writeText(at(name + ".ini"),
                    "[Recording]\nestimate = true\n[Estimator]\ndriver = odometry\n[all]\ndriver = "
                    "RawlogReplay\nprocess_rate = 200\nlabels = ODOM UWB0 PEER GT\nclock = keep\n"
                    "stamps = now\nrawlog = " +
                        at(std::string("three_") + char('A' + i) + ".rawlog") + "\nstart_at_s = " +
                        std::to_string(start_s_) + "\n[Dds]\nrobot = " + std::to_string(i) +
                        "\ndomain = " + domain() + "\nteam = " + team("n") + "\n");
    robots.push_back(std::make_unique<test::Process>(std::vector<std::string>{
        "record", at(name + ".ini"), "--out", at(name + ".rawlog"), "--results", at(name)}));
  }
  pause(25 - playedS());
  for (const auto& robot : robots) end(robot.get());
  std::vector<Pose> worlds;
  for (const char* name : {"a", "b", "c"}) worlds.push_back(worldOf(name, name));
  for (const char* name : {"a", "b", "c"}) {
    const Json map = readJson(folder_ / name / "team.json");
    EXPECT_EQ(map["frame"]["robot"], 0);
    ASSERT_EQ(map["robots"].size(), 3u) << map;
    for (std::size_t i = 0; i < 3; ++i) {
      const Json& robot = map["robots"][i];
      const Pose told(Quat(rotZ(robot["yaw"])), Vec3(robot["t"][0], robot["t"][1], robot["t"][2]));
      // Where its world is told to be, and is, 2 m from its origin.
      const Pose off = (worlds[0].inverse() * worlds[i]).inverse() * told;
      std::printf("%s: robot %zu off by %.3f m\n", name, i,
                  (off * Vec3(2, 0, 0) - Vec3(2, 0, 0)).norm());
      EXPECT_LT((off * Vec3(2, 0, 0) - Vec3(2, 0, 0)).head<2>().norm(), 0.4) << map;
    }
  }
}

/// As a node of ROS 2 on the same domain sees a run, without our code.
TEST_F(TeamLive, Ros2SeesTheTrajectory) {
  const std::string out = at("seen");
  std::string call = quoted(test::buildDir() + "/bin/vir_test_dds_ros_listener") + " " + domain() +
                     " /a > " + quoted(out) + " & pid=$!; " +
                     quoted(test::buildDir() + "/bin/vir-slam") + " record " +
                     quoted(test::sourceDir() + "/ini/live_replay.ini") + " --out " +
                     quoted(at("a.rawlog")) + " --results " + quoted(at("a")) +
                     " --duration-s 5 --set Dds.ros2=true --set Dds.ros2_namespace=a" +
                     " --set Dds.domain=" + domain() + "; code=$?; kill $pid; exit $code";
  const test::Outcome outcome = test::shell(call);
  ASSERT_EQ(outcome.code, 0) << outcome.text;
  EXPECT_TRUE(contains(outcome.text, "topics of ROS 2 on domain")) << outcome.text;
  std::ifstream in(at("a/trajectory.tum"));
  evaluation::ReadReport report;
  std::map<TimeNs, Vec3> path;
  for (const StampedPose& pose : evaluation::readTum(in, &report)) path[pose.t] = pose.T_W_B.p;
  std::istringstream lines(test::readText(out));
  int compared = 0;
  for (std::string line; std::getline(lines, line);) {
    const Json m = Json::parse(line, nullptr, false);
    if (m.is_discarded() || m.value("topic", "") != "odometry") continue;
    EXPECT_EQ(m["frame"], "a/world");
    const auto there = path.find(m["s"].get<TimeNs>() * 1'000'000'000 + m["ns"].get<TimeNs>());
    ASSERT_NE(there, path.end()) << line;
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(m["p"][i].get<double>(), there->second[i], 1e-8);
    ++compared;
  }
  EXPECT_GT(compared, 60);
}

}  // namespace
}  // namespace vir
