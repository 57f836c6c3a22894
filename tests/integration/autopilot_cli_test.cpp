/// vir-slam record with an autopilot at the other end of a UDP port.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <fstream>
#include <map>
#include <thread>

#include "vir/core/crc.h"
#include "vir/core/little_endian.h"
#include "vir/core/order_statistics.h"
#include "vir/geometry/so3.h"
#include "vir_test_paths.h"
#include "vir_test_shell.h"
#include "vir_test_temp_folder.h"

namespace vir {
namespace {

using test::contains;
using test::quoted;

constexpr int kHeartbeat = 0, kVisionPosition = 102, kTimesync = 111, kOdometry = 331;
constexpr std::int64_t kAskedAt = 987654321987;

/// Hears datagrams, and asks for the time once.
class Autopilot {
 public:
  Autopilot() : socket_(::socket(AF_INET, SOCK_DGRAM, 0)) {
    sockaddr_in here{};
    here.sin_family = AF_INET;
    here.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof here;
    EXPECT_EQ(::bind(socket_, reinterpret_cast<sockaddr*>(&here), size), 0);
    EXPECT_EQ(::getsockname(socket_, reinterpret_cast<sockaddr*>(&here), &size), 0);
    port_ = ntohs(here.sin_port);
    const timeval patience{0, 50000};
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    thread_ = std::thread([this] { hear(); });
  }
  ~Autopilot() { stop(); }

  int port() const { return port_; }
  /// Frames by message, each without anything before or behind it.
  const std::map<int, std::vector<std::string>>& stop() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
    if (socket_ >= 0) ::close(socket_);
    socket_ = -1;
    return frames_;
  }

 private:
  void hear() {
    char buffer[512];
    bool asked = false;
    while (!stop_) {
      sockaddr_in from{};
      socklen_t size = sizeof from;
      const ssize_t n =
          ::recvfrom(socket_, buffer, sizeof buffer, 0, reinterpret_cast<sockaddr*>(&from), &size);
      if (n < 12) continue;
      const std::string frame(buffer, static_cast<std::size_t>(n));
      frames_[static_cast<int>(unsignedAt<3>(bytesOf(frame) + 7))].push_back(frame);
      if (asked) continue;
      asked = true;
      const std::string question = questionForTheTime();
      ::sendto(socket_, question.data(), question.size(), 0, reinterpret_cast<sockaddr*>(&from),
               size);
    }
  }

  static std::string questionForTheTime() {
    std::string frame("\xFD\x10\0\0\0\x01\x01\x6F\0\0", 10);
    put(&frame, 0, 8);
    put(&frame, kAskedAt, 8);
    const std::uint8_t extra = 34;
    put(&frame, crc16Mavlink(&extra, 1, crc16Mavlink(bytesOf(frame) + 1, frame.size() - 1)), 2);
    return frame;
  }

  int socket_, port_ = 0;
  std::atomic<bool> stop_{false};
  std::map<int, std::vector<std::string>> frames_;
  std::thread thread_;
};

/// The payload with the zeros at its end back.
std::string payloadOf(const std::string& frame, std::size_t size) {
  std::string payload = frame.substr(10, frame.size() - 12);
  payload.resize(size, '\0');
  return payload;
}

Vec3 vectorAt(const std::string& payload, std::size_t at) {
  const std::uint8_t* p = bytesOf(payload) + at;
  return {floatAt(p), floatAt(p + 4), floatAt(p + 8)};
}

/// Positions in W by stamp [us].
std::map<std::int64_t, Vec3> trajectory(const std::string& file) {
  std::map<std::int64_t, Vec3> out;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    double t = 0, x = 0, y = 0, z = 0;
    if (std::sscanf(line.c_str(), "%lf %lf %lf %lf", &t, &x, &y, &z) != 4) continue;
    out[std::llround(1e6 * t)] = Vec3(x, y, z);
  }
  return out;
}

TEST(AutopilotCli, HearsWhereItIs) {
  const test::TempFolder folder;
  Autopilot autopilot;
  const std::string results = (folder / "run").string();
  const test::Outcome outcome = test::virSlam(
      "record " + quoted(test::sourceDir() + "/ini/live_replay.ini") + " --out " +
      quoted((folder / "a.rawlog").string()) + " --estimate --results " + quoted(results) +
      " --duration-s 12 --set MAVLink.message=both --set MAVLink.port=udp://127.0.0.1:" +
      std::to_string(autopilot.port()));
  ASSERT_EQ(outcome.code, 0) << outcome.text;
  EXPECT_TRUE(contains(outcome.text, " poses sent, 0 not taken, 0 resets, 1 questions for"))
      << outcome.text;
  auto frames = autopilot.stop();
  EXPECT_GE(frames[kHeartbeat].size(), 8u);
  ASSERT_EQ(frames[kTimesync].size(), 1u);
  EXPECT_EQ(unsignedAt<8>(bytesOf(payloadOf(frames[kTimesync][0], 18)) + 8),
            static_cast<std::uint64_t>(kAskedAt));
  ASSERT_GE(frames[kOdometry].size(), 300u);
  EXPECT_EQ(frames[kVisionPosition].size(), frames[kOdometry].size());

  const std::map<std::int64_t, Vec3> path = trajectory(results + "/trajectory.tum");
  ASSERT_GE(path.size(), 100u);
  std::vector<double> off_m;
  std::uint64_t last_us = 0;
  long sure = 0;
  for (const std::string& frame : frames[kOdometry]) {
    const std::string payload = payloadOf(frame, 233);
    const std::uint64_t us = unsignedAt<8>(bytesOf(payload));
    EXPECT_GT(us, last_us);
    last_us = us;
    const auto next = path.lower_bound(static_cast<std::int64_t>(us));
    if (next == path.begin() || next == path.end()) continue;
    const auto before = std::prev(next);
    const double part = static_cast<double>(static_cast<std::int64_t>(us) - before->first) /
                        static_cast<double>(next->first - before->first);
    const Vec3 p_W = before->second + part * (next->second - before->second);
    const Vec3 p_L = vectorAt(payload, 8);
    off_m.push_back((p_L - Vec3(p_W.x(), -p_W.y(), -p_W.z())).norm());
    // The first pose is the origin, known exactly; covariances come with keyframes.
    sure += floatAt(bytesOf(payload) + 60) > 0 ? 1 : 0;
  }
  ASSERT_GE(off_m.size(), 200u);
  EXPECT_GE(sure, 400);
  EXPECT_LT(quantileInPlace(&off_m, 0.95), 0.03);
}

TEST(AutopilotCli, WhatCannotBeIsSaid) {
  const test::TempFolder folder;
  const std::string record = "record " + quoted(test::sourceDir() + "/ini/live_replay.ini") +
                             " --estimate --duration-s 1 --results " +
                             quoted((folder / "run").string()) + " --out ";
  const test::Outcome form = test::virSlam(record + quoted((folder / "a.rawlog").string()) +
                                           " --set MAVLink.port=bluetooth://here");
  EXPECT_EQ(form.code, 1);
  EXPECT_TRUE(contains(form.text, "only tcp:// and udp://")) << form.text;
  const test::Outcome axes =
      test::virSlam(record + quoted((folder / "b.rawlog").string()) +
                    " --set MAVLink.port=udp://127.0.0.1:9" + " --set 'MAVLink.axes=x y -z'");
  EXPECT_EQ(axes.code, 1);
  EXPECT_TRUE(contains(axes.text, "is no rotation")) << axes.text;
}

}  // namespace
}  // namespace vir
