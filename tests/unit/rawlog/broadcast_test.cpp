/// What other robots broadcast, as labels and as observations.
#include <gtest/gtest.h>
#include <mrpt/obs/CObservationBeaconRanges.h>
#include <mrpt/obs/CObservationRobotPose.h>

#include "vir/rawlog/convert.h"
#include "vir/rawlog/labels.h"

namespace vir::rawlog {
namespace {

TEST(BroadcastLabel, BothWays) {
  for (const BroadcastSource& source :
       {BroadcastSource{5, {}}, BroadcastSource{-3, {}}, BroadcastSource{0, 4},
        BroadcastSource{12, 18446744073709551615u}}) {
    const auto back = broadcastSourceOf(broadcastLabel(source));
    ASSERT_TRUE(back) << broadcastLabel(source);
    EXPECT_EQ(back->peer, source.peer);
    EXPECT_EQ(back->anchor, source.anchor);
  }
  EXPECT_EQ(broadcastLabel({5, {}}), "PEER:5");
  EXPECT_EQ(broadcastLabel({5, 7}), "PEER:5:ANCHOR:7");
  EXPECT_EQ(broadcastLabel({5, 7}, "MATE"), "MATE:5:ANCHOR:7");
}

TEST(FurtherLabel, HasItsOwnNumber) {
  EXPECT_EQ(furtherLabel(kCameraLabel, "12"), "CAM12");
  EXPECT_EQ(furtherLabel(kGroundTruthLabel, "1"), "GT1");
}

TEST(BroadcastLabel, OthersAreNone) {
  for (const char* label :
       {"PEER:x", "PEER:5x", "PEER:5:", "PEER:5:ANCHOR", "PEER:5:ANCHOR:", "PEER:5:ANCHOR:-1",
        "PEER:5:ANCHOR:3 ", "PEER:5:anchor:3", "PEER:99999999999", "PEER: 5"}) {
    EXPECT_TRUE(isBroadcastLabel(label)) << label;
    EXPECT_FALSE(broadcastSourceOf(label)) << label;
  }
  for (const char* label : {"", "PEER", "PEER:", "PEERS:5", "UWB0", "ANCHOR:5"}) {
    EXPECT_FALSE(isBroadcastLabel(label)) << label;
    EXPECT_FALSE(broadcastSourceOf(label)) << label;
  }
  EXPECT_FALSE(broadcastSourceOf("PEER:5", "MATE"));
}

TEST(PeerPose, BothWays) {
  PeerPose sent;
  sent.peer = 5;
  sent.world = 2;
  sent.t = 1700000000123456700;
  sent.T_W_B = {Quat(Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized())), Vec3(1, -2, 3)};
  sent.covariance << 4, 1, 0, 1, 5, 2, 0, 2, 6;
  sent.p_B_U = Vec3(0.1, 0.2, 0.3);
  const auto observation = toObservation(sent, kPeerLabel);
  EXPECT_EQ(observation->sensorLabel, "PEER:5:WORLD:2");
  EXPECT_FALSE(broadcastOf(*observation, kPeerLabel)) << "that would be a position";
  const auto back = peerPoseOf(*observation, kPeerLabel);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->peer, 5);
  EXPECT_EQ(back->world, 2);
  EXPECT_EQ(back->t, sent.t);
  EXPECT_LT((back->T_W_B.p - sent.T_W_B.p).norm(), 1e-12);
  EXPECT_LT(back->T_W_B.q.angularDistance(sent.T_W_B.q), 1e-9);
  EXPECT_EQ(back->covariance, sent.covariance);
  EXPECT_EQ(back->p_B_U, sent.p_B_U);
  EXPECT_FALSE(peerPoseOf(*toObservation(PeerBroadcast{5, {}, {}}, kPeerLabel), kPeerLabel));
  for (const char* label : {"PEER:5:WORLD", "PEER:5:WORLD:", "PEER:5:WORLD:-1", "PEER:5:WORLD:x"}) {
    EXPECT_FALSE(broadcastSourceOf(label)) << label;
  }
}

TEST(Broadcast, BothWays) {
  PeerBroadcast sent;
  sent.peer = 5;
  sent.anchor = 7;
  sent.sent.t = 1700000000123456700;
  sent.sent.p_W = Vec3(1, -2, 3);
  sent.sent.covariance << 4, 1, 0, 1, 5, 2, 0, 2, 6;
  const auto observation = toObservation(sent, kPeerLabel);
  const auto back = broadcastOf(*observation, kPeerLabel);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->peer, 5);
  EXPECT_EQ(back->anchor, 7u);
  EXPECT_EQ(back->sent.t, sent.sent.t);
  EXPECT_EQ(back->sent.p_W, sent.sent.p_W);
  EXPECT_EQ(back->sent.covariance, sent.sent.covariance);
  EXPECT_FALSE(broadcastOf(*observation, "MATE"));
  observation->sensorLabel = "PEER:five";
  EXPECT_FALSE(broadcastOf(*observation, kPeerLabel));
  mrpt::obs::CObservationBeaconRanges other;
  other.sensorLabel = "PEER:5";
  EXPECT_FALSE(broadcastOf(other, kPeerLabel)) << "the label alone is not enough";
}

}  // namespace
}  // namespace vir::rawlog
