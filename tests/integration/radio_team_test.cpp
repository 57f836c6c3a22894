/// Two robots that meet live by their radios alone: each a process of its own, no network between
/// them. What LinkTrack radios carry beside ranges is all that they tell each other.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <map>
#include <memory>
#include <regex>
#include <thread>
#include <vector>

#include "robot_truth.h"
#include "vir_test_paths.h"
#include "vir_test_process.h"

namespace vir {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using test::quoted;
using test::readJson;

void pause(double s) { std::this_thread::sleep_for(std::chrono::duration<double>(s)); }

double now() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

class RadioTeam : public testing::Test {
 protected:
  RadioTeam() : start_s_(static_cast<long>(now()) + 6) {}
  std::string at(const std::string& name) const { return (folder_ / name).string(); }
  static std::string sample(const std::string& name) {
    return test::sourceDir() + "/rawlog/two_" + name + ".rawlog";
  }
  void plugInRadio(const std::string& name, int id, const std::string& faults) {
    const std::string call = "exec " + quoted(test::buildDir() + "/bin/vir-device-emulator") + " " +
                             quoted(sample(name)) + " --range-labels PEER --no-wait --start-at " +
                             std::to_string(start_s_) + " --own-id " + std::to_string(id) +
                             " --air " + at("air") + faults +
                             " --uwb nlink=" + at("radio_" + name) + " > /dev/null 2>&1";
    helpers_.push_back(fork());
    if (helpers_.back() == 0) {
      execl("/bin/sh", "sh", "-c", call.c_str(), nullptr);
      _exit(127);
    }
    for (int i = 0; i < 200 && !fs::exists(at("radio_" + name)); ++i) pause(0.05);
  }
  void TearDown() override {
    for (const pid_t pid : helpers_) {
      kill(pid, SIGKILL);
      waitpid(pid, nullptr, 0);
    }
  }
  std::unique_ptr<test::Process> start(const std::string& name, int id) {
    std::string text = "[Recording]\nestimate = true\n[Estimator]\ndriver = vir\n";
    for (const auto& [section, label] : std::map<std::string, std::string>{
             {"camera", "CAM0"}, {"inertial", "IMU0"}, {"radio", "UWB0"}, {"truth", "GT"}}) {
      text += "[" + section +
              "]\ndriver = RawlogReplay\nprocess_rate = 200\nrawlog = " + sample(name) +
              "\nlabels = " + label +
              "\nclock = keep\nstamps = now\nstart_at_s = " + std::to_string(start_s_) + "\n";
    }
    text +=
        "[mates]\ndriver = UwbSerial\nprocess_rate = 500\nsensorLabel = MATES\nclock = keep\n"
        "protocol = nlink\nantenna_m = 0.03 0 0.08\nstd_error_m = 0.06\ntell_hz = 10\nown_id = " +
        std::to_string(id) + "\npeer_ids = " + std::to_string(1 - id) +
        "\nport = " + at("radio_" + name) + "\n";
    test::writeText(at(name + ".ini"), text);
    return std::make_unique<test::Process>(std::vector<std::string>{
        "record", at(name + ".ini"), "--out", at(name + ".rawlog"), "--results", at(name)});
  }
  Pose worldOf(const std::string& name) const {
    std::ifstream in(at(name + "/trajectory.tum"));
    evaluation::ReadReport report;
    return test::worldOf(test::truthIn(at(name + ".rawlog")), evaluation::readTum(in, &report));
  }
  void expectTransform(const std::string& results, const std::string& name,
                       const std::string& other) const {
    const Json t = readJson(folder_ / results / "transforms.json")["transforms"][0];
    ASSERT_EQ(t["status"], "unique") << t;
    const test::Deviation d = test::deviation(t, worldOf(name).inverse() * worldOf(other));
    std::printf("%s: offset off by %.3f m, yaw by %.2f deg, after %s s\n", results.c_str(),
                d.offset_m, d.yaw_deg, t["first_unique_s"].dump().c_str());
    EXPECT_LT(d.offset_m, 0.4);
    EXPECT_LT(d.yaw_deg, 4);
  }
  /// "mates: NAME 12" of what a recording says at its end; 0 where it does not.
  static long counted(const std::string& text, const std::string& name) {
    std::smatch match;
    const std::regex line("mates: " + name + " (\\d+)");
    return std::regex_search(text, match, line) ? std::stol(match[1]) : 0;
  }
  /// Both play for 16 s and end as a user ends them; gives what they say.
  std::vector<std::string> meet(const std::string& faults) {
    plugInRadio("A", 0, faults);
    plugInRadio("B", 1, faults);
    const auto a = start("A", 0), b = start("B", 1);
    pause(static_cast<double>(start_s_) + 16 - now());
    std::vector<std::string> texts;
    for (test::Process* robot : {a.get(), b.get()}) {
      robot->send(SIGINT);
      EXPECT_EQ(robot->wait(), 0) << robot->text();
      texts.push_back(robot->text());
    }
    return texts;
  }

  long start_s_ = 0;
  test::TempFolder folder_;
  std::vector<pid_t> helpers_;
};

TEST_F(RadioTeam, TheyMeetWithoutANetwork) {
  for (const std::string& text : meet("")) {
    EXPECT_GT(counted(text, "told"), 100) << text;
    EXPECT_GT(counted(text, "heard_accepted"), 80) << text;
    EXPECT_EQ(counted(text, "heard_damaged"), 0) << text;
  }
  expectTransform("A", "A", "B");
  expectTransform("B", "B", "A");
  // What was heard is recorded: the same is found from the file alone.
  const test::Outcome again =
      test::virSlam("run " + quoted(at("A/used.ini")) + " --rawlog " + quoted(at("A.rawlog")) +
                    " --out " + quoted(at("again")));
  EXPECT_EQ(again.code, 0) << again.text;
  expectTransform("again", "A", "B");
  EXPECT_FALSE(fs::exists(at("A_late.rawlog")));
}

TEST_F(RadioTeam, OverABadAir) {
  for (const std::string& text : meet(" --air-lost 0.3 --air-damaged 0.1")) {
    EXPECT_GT(counted(text, "heard_accepted"), 50) << text;
    EXPECT_GT(counted(text, "heard_damaged"), 3) << text;
    EXPECT_GT(counted(text, "heard_lost"), 20) << text;
  }
  expectTransform("A", "A", "B");
  expectTransform("B", "B", "A");
}

}  // namespace
}  // namespace vir
