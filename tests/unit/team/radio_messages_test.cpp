#include "vir/team/radio_messages.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>

namespace vir::team {
namespace {

constexpr TimeNs kSecond = 1'000'000'000, kNow = 1'700'000'000 * kSecond;

StateEstimate estimateAt(TimeNs t, int segment = 0) {
  StateEstimate e;
  e.valid = true;
  e.segment = segment;
  e.state.t = t;
  e.state.T_W_B = Pose(Quat(Eigen::AngleAxisd(M_PI / 2, Vec3::UnitZ())), Vec3(1, 2, 3));
  e.covariance.diagonal() << 0.01, 0.01, 0.04, 0, 0, 0.01;
  return e;
}

Anchor anchor(std::uint64_t id, AnchorState state = AnchorState::estimated) {
  Anchor a;
  a.id = id;
  a.state = state;
  a.has_position = true;
  a.p_W = Vec3(static_cast<double>(id), 5, 6);
  a.covariance = 0.01 * Mat3::Identity();
  return a;
}

PeerMessage decoded(const PeerPacket& packet) {
  PeerMessage m;
  EXPECT_EQ(decode(packet.data(), packet.size(), &m), PeerDecoding::ok);
  return m;
}

TEST(RadioTeller, TellsWhereTheAntennaIsAtItsRate) {
  RadioTeller teller(7, 5, 10, Vec3(1, 0, 0.5));
  int told = 0;
  for (int i = 0; i < 100; ++i)
    told += teller.tell(estimateAt(kNow + i * kSecond / 50), {}) ? 1 : 0;
  EXPECT_EQ(told, 20);
  const PeerMessage m = decoded(*teller.tell(estimateAt(kNow + 3 * kSecond), {}));
  EXPECT_EQ(m.robot, 7);
  EXPECT_EQ(m.segment, 5 << kWorldBits);
  EXPECT_EQ(m.sequence, 20);
  EXPECT_LT((m.p_W - Vec3(1, 3, 3.5)).norm(), 1e-4);
  // A metre ahead of a body whose heading is known to 0.1 rad: 0.1 m more across it, in x.
  EXPECT_NEAR(std::sqrt(m.covariance(0, 0)), std::sqrt(0.02), 0.01);
  EXPECT_NEAR(std::sqrt(m.covariance(1, 1)), 0.1, 0.006);
}

TEST(RadioTeller, OneAnchorAfterTheOtherOfThoseThatItBelievesIn) {
  RadioTeller teller(7, 5, 10, Vec3::Zero());
  const std::vector<Anchor> anchors{anchor(1), anchor(2, AnchorState::collecting), anchor(70000),
                                    anchor(4)};
  std::vector<int> ids;
  for (int i = 0; i < 4; ++i) {
    ids.push_back(decoded(*teller.tell(estimateAt(kNow + i * kSecond), anchors)).anchor->id);
  }
  EXPECT_EQ(ids, (std::vector<int>{1, 4, 1, 4}));
}

TEST(RadioTeller, SaysNothingOfWhatItDoesNotKnow) {
  RadioTeller teller(7, 5, 10, Vec3::Zero());
  StateEstimate e = estimateAt(kNow);
  e.valid = false;
  EXPECT_FALSE(teller.tell(e, {}));
  e = estimateAt(kNow);
  e.state.T_W_B.p.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(teller.tell(e, {}));
  e = estimateAt(kNow);
  e.state.T_W_B.p.x() = 3e5;
  EXPECT_FALSE(teller.tell(e, {}));
  EXPECT_TRUE(teller.tell(estimateAt(kNow + kSecond), {}));
}

class Radios : public testing::Test {
 protected:
  using Bytes = std::vector<std::uint8_t>;
  static Bytes bytesOf(const PeerPacket& p) { return {p.begin(), p.end()}; }
  /// The `i`-th message of the robot, 0.1 s after the one before.
  Bytes message(int i, int segment = 0) {
    return bytesOf(*teller_.tell(estimateAt(kNow + i * kSecond / 10, segment), {anchor(9)}));
  }
  std::vector<HeardReport> add(const Bytes& bytes, int i, std::int64_t sender = 7) {
    return inbox_.add(sender, bytes.data(), bytes.size(), kNow + i * kSecond / 10, 0.1 * i);
  }
  long count(const std::string& name) const {
    for (const auto& [key, n] : inbox_.counters()) {
      if (key == name) return n;
    }
    return 0;
  }
  std::vector<std::string> lines_;
  RadioTeller teller_{7, 5, 10, Vec3::Zero()};
  RadioInbox inbox_{std::uint16_t{3},
                    [this](LogLevel, const std::string& text) { lines_.push_back(text); }};
};

TEST_F(Radios, WhatOneTellsTheOtherHears) {
  const auto heard = add(message(0), 0);
  ASSERT_EQ(heard.size(), 1u);
  EXPECT_EQ(heard[0].pose.peer, 7);
  EXPECT_EQ(heard[0].pose.world, 0);
  EXPECT_EQ(heard[0].pose.t, kNow);
  EXPECT_LT((heard[0].pose.T_W_B.p - Vec3(1, 2, 3)).norm(), 1e-4);
  ASSERT_EQ(heard[0].anchors.size(), 1u);
  EXPECT_EQ(heard[0].anchors[0].anchor, 9u);
  EXPECT_LT((heard[0].anchors[0].sent.p_W - Vec3(9, 5, 6)).norm(), 1e-4);
}

TEST_F(Radios, InPiecesAndSeveralAtOnce) {
  Bytes all = message(0);
  const Bytes next = message(1);
  all.insert(all.end(), next.begin(), next.end());
  for (std::size_t piece : {1, 7, 60, 61, 120}) {
    RadioInbox inbox(std::nullopt, {});
    std::size_t heard = 0;
    for (std::size_t at = 0; at < all.size(); at += piece) {
      const std::size_t n = std::min(piece, all.size() - at);
      heard += inbox.add(7, all.data() + at, n, kNow, 0).size();
    }
    EXPECT_EQ(heard, 2u) << piece;
  }
}

TEST_F(Radios, DamagedOnesAreCountedAndTheNextIsHeard) {
  for (int at = 0; at < 60; ++at) {
    Bytes damaged = message(2 * at);
    damaged[static_cast<std::size_t>(at)] ^= 0x40;
    EXPECT_TRUE(add(damaged, 2 * at).empty()) << at;
    // One whose first byte is damaged is none; one that waits for its end takes the next along.
    EXPECT_EQ(add(message(2 * at + 1), 2 * at + 1).size(), 1u) << at;
  }
  EXPECT_EQ(count("damaged"), 58);
  EXPECT_EQ(count("other_version"), 1);
  EXPECT_GE(count("foreign_bytes"), 60);
  EXPECT_EQ(count("accepted"), 60);
}

TEST_F(Radios, TruncatedOnesAreCounted) {
  Bytes half = message(0);
  half.resize(35);
  EXPECT_TRUE(add(half, 0).empty());
  EXPECT_EQ(add(message(1), 1).size(), 1u);
  EXPECT_EQ(count("damaged"), 1);
  half = message(2);
  half.resize(35);
  EXPECT_TRUE(add(half, 2).empty());
  EXPECT_EQ(add(message(30), 30).size(), 1u) << "the rest never came";
  EXPECT_EQ(count("damaged"), 2);
}

TEST_F(Radios, WhatIsNotOursIsCounted) {
  const std::string text = "hello from another program";
  EXPECT_TRUE(add(Bytes(text.begin(), text.end()), 0).empty());
  EXPECT_EQ(count("foreign_bytes"), static_cast<long>(text.size()));
  EXPECT_TRUE(add(message(1), 1, 8).empty());
  EXPECT_EQ(count("of_another_radio"), 1);
  EXPECT_EQ(count("accepted"), 0);
}

TEST_F(Radios, LateAndRepeatedOnesAreRefused) {
  const Bytes once = message(0);
  EXPECT_EQ(add(once, 0).size(), 1u);
  EXPECT_TRUE(add(once, 1).empty());
  EXPECT_EQ(count("repeated"), 1);
  EXPECT_TRUE(add(message(2), 50).empty());
  EXPECT_EQ(count("late"), 1);
  EXPECT_TRUE(add(message(60), 51).empty());
  EXPECT_EQ(count("other_clock"), 1);
}

TEST_F(Radios, ANewSegmentAndANewStartAreNewWorlds) {
  EXPECT_EQ(add(message(0), 0)[0].pose.world, 0);
  EXPECT_EQ(add(message(1, 1), 1)[0].pose.world, 1);
  EXPECT_EQ(add(message(2, 1), 2)[0].pose.world, 1);
  teller_ = RadioTeller(7, 6, 10, Vec3::Zero());
  EXPECT_EQ(add(message(30), 30).at(0).pose.world, 2);
  EXPECT_EQ(add(message(31), 31).at(0).pose.world, 2);
}

/// 16 bits count anew after two hours.
TEST_F(Radios, TheSequenceGoesOnWhereItBeginsAnew) {
  long heard = 0;
  for (int i = 0; i < 70000; ++i) heard += static_cast<long>(add(message(i), i).size());
  EXPECT_EQ(heard, 70000);
  EXPECT_EQ(count("lost"), 0);
}

TEST_F(Radios, MemoryIsBounded) {
  Bytes noise(500);
  std::iota(noise.begin(), noise.end(), std::uint8_t{0});
  for (int i = 0; i < 100; ++i) EXPECT_TRUE(add(noise, i, i).empty());
  EXPECT_EQ(count("too_many_radios"), 68);
}

}  // namespace
}  // namespace vir::team
