#include "hand_over.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <stdexcept>

namespace vir::estimator {
namespace {

using Ids = std::vector<std::uint64_t>;

/// Says of packet k (from 1): drop track k, k segments begun.
struct CountingBackEnd {
  std::atomic<long> done{0};

  Feedback operator()(const Packet& packet) {
    if (packet.stamp < 0) throw std::runtime_error("cannot work on it");
    Feedback out;
    ++done;
    out.wrong_tracks = {static_cast<std::uint64_t>(packet.stamp)};
    out.resets = static_cast<int>(packet.stamp);
    return out;
  }
};

Packet packetAt(TimeNs stamp) {
  Packet p;
  p.stamp = stamp;
  return p;
}

struct Fixture {
  explicit Fixture(int lag) : hand_over([this](const Packet& p) { return back(p); }, lag) {}
  Feedback ask() { return hand_over.ask(&covered); }

  CountingBackEnd back;
  HandOver hand_over;
  long covered = -1;
};

TEST(HandOver, WithoutLagAllIsKnown) {
  Fixture f(0);
  EXPECT_TRUE(f.ask().wrong_tracks.empty());
  EXPECT_EQ(f.covered, 0);
  f.hand_over.give(packetAt(1));
  EXPECT_EQ(f.ask().wrong_tracks, Ids({1}));
  EXPECT_EQ(f.covered, 1);
  EXPECT_TRUE(f.ask().wrong_tracks.empty()) << "told once";
  EXPECT_EQ(f.ask().resets, 1) << "still true";
}

/// With a thread or without, what is known is the same.
TEST(HandOver, WithALagTheLastPacketIsNotKnown) {
  for (const bool thread : {false, true}) {
    Fixture f(1);
    if (thread) f.hand_over.startThread([] {});
    f.hand_over.give(packetAt(1));
    EXPECT_EQ(f.ask().resets, 0);
    EXPECT_EQ(f.covered, 0);
    // Packets without an image nobody asks about: their drops come together.
    for (const TimeNs stamp : {2, 3, 4}) f.hand_over.give(packetAt(stamp));
    const Feedback known = f.ask();
    EXPECT_EQ(f.covered, 3);
    EXPECT_EQ(known.resets, 3);
    EXPECT_EQ(known.wrong_tracks, Ids({1, 2, 3}));
    f.hand_over.drain();
    EXPECT_EQ(f.back.done, 4);
  }
}

TEST(HandOver, CallsAfterEachPacketInTheThread) {
  Fixture f(1);
  std::vector<std::thread::id> calls;
  f.hand_over.startThread([&] { calls.push_back(std::this_thread::get_id()); });
  for (TimeNs stamp = 1; stamp <= 20; ++stamp) f.hand_over.give(packetAt(stamp));
  f.hand_over.drain();
  ASSERT_EQ(calls.size(), 20u);
  EXPECT_EQ(calls.front(), calls.back());
  EXPECT_NE(calls.front(), std::this_thread::get_id());
}

TEST(HandOver, WhatTheThreadThrowsComesOut) {
  Fixture f(1);
  f.hand_over.startThread([] {});
  f.hand_over.give(packetAt(-1));
  EXPECT_THROW(f.hand_over.drain(), std::runtime_error);
  EXPECT_THROW(f.hand_over.give(packetAt(2)), std::runtime_error);
  EXPECT_THROW(f.ask(), std::runtime_error);
}

TEST(HandOver, WithoutAThreadAFailureIsNotWaitedFor) {
  Fixture f(0);
  EXPECT_THROW(f.hand_over.give(packetAt(-1)), std::runtime_error);
  EXPECT_THROW(f.ask(), std::runtime_error);
  EXPECT_THROW(f.hand_over.drain(), std::runtime_error);
  f.hand_over.wait();
}

TEST(HandOver, EndsWithPacketsLeft) {
  Fixture f(1);
  f.hand_over.startThread([] { std::this_thread::sleep_for(std::chrono::milliseconds(5)); });
  for (TimeNs stamp = 1; stamp <= 100; ++stamp) f.hand_over.give(packetAt(stamp));
}

TEST(HandOver, AThreadNeedsALagAndAFreshStart) {
  Fixture without(0);
  EXPECT_THROW(without.hand_over.startThread([] {}), std::logic_error);
  Fixture late(1);
  late.hand_over.give(packetAt(1));
  EXPECT_THROW(late.hand_over.startThread([] {}), std::logic_error);
}

}  // namespace
}  // namespace vir::estimator
