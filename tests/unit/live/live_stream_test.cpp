/// Poses between estimates, and the socket they go over.
#include <arpa/inet.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <cmath>
#include <string>

#include "vir/geometry/so3.h"
#include "vir/live/line_server.h"
#include "vir/live/pose_propagator.h"

namespace vir::live {
namespace {

constexpr double kRate = 0.8, kRadius = 2;  // [rad/s], [m]

/// Round in a circle, nose ahead: yaw = kRate t.
const Vec3 kBiasGyro(0.01, -0.02, 0.03), kBiasAcc(0.1, 0.2, -0.3);
constexpr double kGravity = 9.79;  // not everywhere is it 9.81

State truth(double t) {
  State out;
  out.t = fromSeconds(t);
  const double a = kRate * t;
  out.T_W_B = Pose(Quat(Eigen::AngleAxisd(a, Vec3::UnitZ())),
                   Vec3(kRadius * std::sin(a), -kRadius * std::cos(a), 1));
  out.bg = kBiasGyro;
  out.ba = kBiasAcc;
  out.v = kRadius * kRate * Vec3(std::cos(a), std::sin(a), 0);
  return out;
}

ImuSample reading(double t) {
  ImuSample s;
  s.t = fromSeconds(t);
  s.gyro = Vec3(0, 0, kRate) + kBiasGyro;
  s.acc = Vec3(0, kRadius * kRate * kRate, kGravity) + kBiasAcc;
  return s;
}

TEST(PosePropagator, FollowsACircleFromALateEstimate) {
  PosePropagator propagator(kGravity);
  double worst = 0;
  for (int k = 0; k <= 600; ++k) {
    const double t = 0.005 * k;
    const auto pose = propagator.add(reading(t));
    if (k < 40) {
      EXPECT_FALSE(pose) << "there was no estimate yet";
    } else {
      ASSERT_TRUE(pose) << k;
      EXPECT_EQ(pose->t, fromSeconds(t));
      worst = std::max(worst, (pose->T_W_B.p - truth(t).T_W_B.p).norm());
      EXPECT_LT(logQuat(pose->T_W_B.q.conjugate() * truth(t).T_W_B.q).norm(), 1e-6);
      EXPECT_LT((pose->v - truth(t).v).norm(), 1e-3);
    }
    // An estimate of 32.5 ms ago, between two readings, ten times per second.
    if (k >= 20 && k % 20 == 19) {
      propagator.setState(truth(t - 0.0325));
    }
  }
  EXPECT_LT(worst, 1e-4);
}

TEST(PosePropagator, SaysNothingWithoutAFreshEstimate) {
  PosePropagator propagator(kGravity);
  const State at = truth(0);
  propagator.add(reading(0));
  propagator.setState(at);
  EXPECT_TRUE(propagator.add(reading(0.005)));
  EXPECT_FALSE(propagator.add(reading(0.005))) << "the same reading again";
  EXPECT_FALSE(propagator.add(reading(0.7)));
  propagator.setState(at);
  propagator.clear();
  EXPECT_FALSE(propagator.add(reading(0.705)));
}

int connectTo(int port) {
  const int handle = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in at{};
  at.sin_family = AF_INET;
  at.sin_port = htons(static_cast<std::uint16_t>(port));
  inet_pton(AF_INET, "127.0.0.1", &at.sin_addr);
  EXPECT_EQ(connect(handle, reinterpret_cast<sockaddr*>(&at), sizeof at), 0);
  return handle;
}

TEST(LineServer, SendsToAllAndOutlivesWhoLeaves) {
  LineServer server("127.0.0.1", 0);
  server.send("nobody hears this");
  const int a = connectTo(server.port()), b = connectTo(server.port());
  server.send("one");
  EXPECT_EQ(server.clients(), 2u);
  close(b);
  for (int i = 0; i < 5; ++i) {
    server.send("two");
    usleep(5000);
  }
  EXPECT_EQ(server.clients(), 1u);
  char text[100] = {};
  const ssize_t n = read(a, text, sizeof text - 1);
  EXPECT_EQ(std::string(text, static_cast<std::size_t>(n)), "one\ntwo\ntwo\ntwo\ntwo\ntwo\n");
  close(a);
}

TEST(LineServer, DoesNotWaitForAClientThatDoesNotRead) {
  LineServer server("127.0.0.1", 0);
  const int a = connectTo(server.port());
  const std::string line(1000, 'x');
  server.send(line);
  EXPECT_EQ(server.clients(), 1u);
  for (int i = 0; i < 20000 && server.clients() > 0; ++i) server.send(line);
  EXPECT_EQ(server.clients(), 0u);
  close(a);
}

std::string heardFrom(int handle) {
  timeval wait{2, 0};
  setsockopt(handle, SOL_SOCKET, SO_RCVTIMEO, &wait, sizeof wait);
  char text[200] = {};
  const ssize_t n = read(handle, text, sizeof text - 1);
  return n > 0 ? std::string(text, static_cast<std::size_t>(n)) : "";
}

int openDescriptors() {
  int n = 0;
  for (int i = 0; i < 4096; ++i) n += fcntl(i, F_GETFD) >= 0 ? 1 : 0;
  return n;
}

/// 1,300 of them once took all descriptors that the recording needed, and 200 got no data.
TEST(LineServer, ACrowdCostsNoMoreThanItsLimit) {
  LineServer server("127.0.0.1", 0, {4, ""});
  std::vector<int> crowd;
  const int before = openDescriptors();
  for (int i = 0; i < 300; ++i) crowd.push_back(connectTo(server.port()));
  for (int i = 0; i < 200 && server.refused() < 296; ++i) usleep(10000);
  EXPECT_EQ(server.refused(), 296);
  EXPECT_EQ(server.clients(), 4u);
  EXPECT_LE(openDescriptors() - before, 304);
  EXPECT_NE(heardFrom(crowd.back()).find("too many clients"), std::string::npos);
  server.send("one");
  EXPECT_EQ(heardFrom(crowd.front()), "one\n");
  // Who leaves makes room.
  close(crowd.front());
  for (int i = 0; i < 3; ++i) {
    server.send("two");
    usleep(5000);
  }
  const int late = connectTo(server.port());
  server.send("three");
  EXPECT_EQ(heardFrom(late), "three\n");
  close(late);
  for (std::size_t i = 1; i < crowd.size(); ++i) close(crowd[i]);
}

TEST(LineServer, AsksForTheToken) {
  LineServer server("127.0.0.1", 0, {4, "s3cret"});
  const int friendly = connectTo(server.port()), stranger = connectTo(server.port()),
            silent = connectTo(server.port());
  ASSERT_EQ(write(friendly, "s3cret\r\n", 8), 8);
  ASSERT_EQ(write(stranger, "s3cre\n", 6), 6);
  for (int i = 0; i < 200 && server.refused() + static_cast<long>(server.clients()) < 2; ++i) {
    usleep(10000);
  }
  EXPECT_EQ(server.clients(), 1u);
  EXPECT_EQ(server.refused(), 1);
  server.send("pose");
  EXPECT_EQ(heardFrom(friendly), "pose\n");
  EXPECT_NE(heardFrom(stranger).find("must be the token"), std::string::npos);
  for (const int handle : {friendly, stranger, silent}) close(handle);
}

TEST(LineServer, SaysWhyItCannotListen) {
  EXPECT_THROW(LineServer("no address", 0), std::runtime_error);
  LineServer first("127.0.0.1", 0);
  EXPECT_THROW(LineServer("127.0.0.1", first.port()), std::runtime_error);
}

}  // namespace
}  // namespace vir::live
