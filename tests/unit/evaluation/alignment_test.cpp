#include "vir/evaluation/alignment.h"

#include <gtest/gtest.h>

#include "made_trajectories.h"

namespace vir::evaluation {
namespace {

std::vector<PosePair> pairsOf(const Trajectory& reference, const Trajectory& estimate) {
  return associate(reference, estimate, {}).pairs;
}

TEST(Align, WordsAndNames) {
  for (const char* word : {"none", "posyaw", "se3", "sim3"}) {
    Alignment a;
    ASSERT_TRUE(parseAlignment(word, &a));
    EXPECT_STREQ(name(a), word);
  }
  Alignment a;
  EXPECT_FALSE(parseAlignment("SE3", &a));
  EXPECT_FALSE(parseAlignment("", &a));
}

TEST(Align, RecoversAKnownTransformOfEachKind) {
  const Trajectory est = test::winding(20, 10);
  for (const double yaw : {0.0, 0.3, 1.5707, 3.1, -3.14159, -2.0}) {
    const Pose T4(Quat(rotZ(yaw)), Vec3(10, -20, 3));
    const AlignmentResult posyaw = align(pairsOf(test::seenFrom(est, T4), est), Alignment::posyaw);
    EXPECT_LT(posyaw.T_R_E.q.angularDistance(T4.q), 1e-12) << yaw;
    EXPECT_LT((posyaw.T_R_E.p - T4.p).norm(), 1e-11) << yaw;
    EXPECT_EQ(posyaw.scale, 1);
    EXPECT_EQ(posyaw.note, "");

    const Pose T6(expQuat(Vec3(0.7, -0.4, yaw)), Vec3(1, 2, 3));
    const AlignmentResult se3 = align(pairsOf(test::seenFrom(est, T6), est), Alignment::se3);
    EXPECT_LT(se3.T_R_E.q.angularDistance(T6.q), 1e-11) << yaw;
    EXPECT_LT((se3.T_R_E.p - T6.p).norm(), 1e-11) << yaw;

    const AlignmentResult sim3 = align(pairsOf(test::seenFrom(est, T6, 2.5), est), Alignment::sim3);
    EXPECT_NEAR(sim3.scale, 2.5, 1e-12) << yaw;
    EXPECT_LT(sim3.T_R_E.q.angularDistance(T6.q), 1e-11) << yaw;
    EXPECT_LT((sim3.T_R_E.p - T6.p).norm(), 1e-10) << yaw;
  }
}

/// Below four hundredths of a metre rms: the attitudes say how it is turned.
TEST(Align, AReferenceThatHardlyMovesStandsStill) {
  for (const double radius_m : {0.03, 0.05}) {
    std::vector<PosePair> pairs(4);
    for (std::size_t i = 0; i < 4; ++i) {
      const double x = i % 2 == 0 ? radius_m : -radius_m;
      pairs[i].reference.p = pairs[i].estimate.p = i < 2 ? Vec3(x, 0, 0) : Vec3(0, x, 0);
    }
    for (const Alignment kind : {Alignment::posyaw, Alignment::se3}) {
      const bool still = align(pairs, kind).note.find("stands still") != std::string::npos;
      EXPECT_EQ(still, radius_m < 0.04) << radius_m;
    }
  }
}

TEST(Align, PosYawByHand) {
  // Estimate: (0,0,0), (2,0,0), (2,2,0); reference the same turned by +90 deg and moved by (1,0,5):
  // (1,0,5), (1,2,5), (-1,2,5).
  const Vec3 e[] = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}};
  const Vec3 r[] = {{1, 0, 5}, {1, 2, 5}, {-1, 2, 5}};
  std::vector<PosePair> pairs(3);
  for (int i = 0; i < 3; ++i) {
    pairs[i].reference.p = r[i];
    pairs[i].estimate.p = e[i];
  }
  const AlignmentResult a = align(pairs, Alignment::posyaw);
  EXPECT_NEAR(yawOf(a.T_R_E.R()), 1.5707963267948966, 1e-14);
  EXPECT_LT((a.T_R_E.p - Vec3(1, 0, 5)).norm(), 1e-14);
}

TEST(Align, PosYawLeavesTiltAlone) {
  const Trajectory est = test::winding(20, 10);
  const Trajectory ref = test::seenFrom(est, Pose(expQuat(Vec3(0.1, 0, 0)), Vec3::Zero()));
  const AlignmentResult a = align(pairsOf(ref, est), Alignment::posyaw);
  EXPECT_LT((a.T_R_E.R() * Vec3::UnitZ() - Vec3::UnitZ()).norm(), 1e-15);
}

TEST(Align, AMirrorImageIsNotARotation) {
  Trajectory est = test::winding(20, 10);
  Trajectory ref = est;
  for (StampedPose& pose : ref) pose.T_W_B.p.x() *= -1;
  for (const Alignment kind : {Alignment::se3, Alignment::sim3}) {
    EXPECT_NEAR(align(pairsOf(ref, est), kind).T_R_E.R().determinant(), 1, 1e-12);
  }
}

TEST(Align, StandingStillTakesTheRotationFromTheAttitudes) {
  std::vector<PosePair> pairs(10);
  for (PosePair& pair : pairs) {
    pair.estimate = Pose(expQuat(Vec3(0.2, 0.1, 0)), Vec3(4, 4, 4));
    pair.reference = Pose(Quat(rotZ(0.8)) * pair.estimate.q, Vec3(1, 2, 3));
  }
  for (const Alignment kind : {Alignment::posyaw, Alignment::se3, Alignment::sim3}) {
    const AlignmentResult a = align(pairs, kind);
    EXPECT_NE(a.note, "") << name(kind);
    EXPECT_EQ(a.scale, 1) << name(kind);
    const Pose T = a.apply(pairs[0].estimate);
    EXPECT_LT((T.p - Vec3(1, 2, 3)).norm(), 1e-12) << name(kind);
    EXPECT_LT(T.q.angularDistance(pairs[0].reference.q), 1e-7) << name(kind);
  }
}

TEST(Align, StraightUpHasNoYawInThePositions) {
  std::vector<PosePair> pairs(10);
  for (int i = 0; i < 10; ++i) {
    pairs[i].estimate.p = Vec3(0, 0, i);
    pairs[i].reference = Pose(Quat(rotZ(-0.5)), Vec3(7, 0, i));
  }
  const AlignmentResult a = align(pairs, Alignment::posyaw);
  EXPECT_NE(a.note, "");
  EXPECT_NEAR(yawOf(a.T_R_E.R()), -0.5, 1e-12);
}

TEST(Align, AStraightLineIsSaidToLeaveARotationOpen) {
  std::vector<PosePair> pairs(10);
  for (int i = 0; i < 10; ++i) pairs[i].estimate.p = pairs[i].reference.p = Vec3(i, 0, 0);
  const AlignmentResult a = align(pairs, Alignment::se3);
  EXPECT_NE(a.note, "");
  EXPECT_LT((a.apply(pairs[9].estimate).p - Vec3(9, 0, 0)).norm(), 1e-12);
  EXPECT_TRUE(a.T_R_E.q.coeffs().allFinite());
}

TEST(Align, NoPairs) {
  EXPECT_NO_THROW(align({}, Alignment::none));
  EXPECT_THROW(align({}, Alignment::posyaw), std::invalid_argument);
}

}  // namespace
}  // namespace vir::evaluation
