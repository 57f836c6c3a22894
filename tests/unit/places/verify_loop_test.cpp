/// The pose of a second visit against what is true, and what must be refused.
#include "vir/places/verify_loop.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <limits>

#include "loop_pose.h"
#include "made_places.h"
#include "vir/core/angles.h"

namespace {

using namespace vir;
using places::LoopRefusal;
using places::LoopVerdict;
using places::RelativePrior;
using places::verifyLoop;
using vir_test::MadeWorld;
using vir_test::standing;
using Mat6 = Eigen::Matrix<double, 6, 6>;

using Older = std::vector<std::shared_ptr<const PlaceKeyframe>>;

double distanceTo(const LoopVerdict& v, const Pose& truth) {
  return (v.loop->T_older_newer.p - truth.p).norm();
}
double turnTo(const LoopVerdict& v, const Pose& truth) {
  return v.loop->T_older_newer.q.angularDistance(truth.q);
}

TEST(TwoPoints, GiveYawAndDistances) {
  Random random(5);
  const auto any = [&](double s) {
    return Vec3(s * random.normal(), s * random.normal(), s * random.normal());
  };
  for (int k = 0; k < 500; ++k) {
    const double yaw = random.uniform(-kPi, kPi);
    const Vec3 t = any(2), x1 = any(4), x2 = any(4), e1 = any(0.3), e2 = any(0.3);
    const Vec3 y1 = rotZ(yaw) * x1 + t - e1, y2 = rotZ(yaw) * x2 + t - e2;
    const auto all = places::solveTwoPoints(x1 - x2, y1.normalized(), y2.normalized(), e1 - e2);
    ASSERT_LE(all.size(), 2U);
    double nearest = 1;
    for (const auto& s : all) {
      ASSERT_GT(s.a, 0);
      ASSERT_GT(s.b, 0);
      nearest = std::min(nearest, std::abs(std::remainder(s.yaw - yaw, 2 * kPi)) +
                                      std::abs(s.a - y1.norm()) + std::abs(s.b - y2.norm()));
    }
    ASSERT_LT(nearest, 1e-5) << k;
  }
}

TEST(TwoPoints, LevelRaysAndOnePointTwiceGiveNothing) {
  EXPECT_TRUE(
      places::solveTwoPoints(Vec3(1, 0, 0), Vec3::UnitX(), Vec3::UnitY(), Vec3::Zero()).empty());
  EXPECT_TRUE(
      places::solveTwoPoints(Vec3(1, 0, 0), Vec3(0, 0, 1), Vec3(0, 0, 1), Vec3::Zero()).empty());
}

/// The residual's derivatives are those of its values.
TEST(Sight, JacobianIsThatOfTheResidual) {
  places::LevelPoint a, b;
  a.ray = Vec3(0.8, 0.1, 0.2).normalized();
  a.eye = Vec3(0.1, -0.2, 0.05);
  a.rho = 0.4;
  a.sigma = 0.01;
  b.eye = Vec3(-0.1, 0.1, 0.02);
  for (const bool forward : {true, false}) {
    const Pose T(expQuat(Vec3(0.02, -0.03, 0.3)), Vec3(0.3, -0.4, 0.1));
    const Vec3 p = a.eye + a.ray / a.rho;
    b.ray = ((forward ? T.inverse() * p : T * p) - b.eye).normalized();
    const places::Sight sight{&a, &b, forward};
    const auto at = [&](const Eigen::Matrix<double, 6, 1>& d) {
      const Pose moved(T.q * expQuat(d.tail<3>()), T.p + d.head<3>());
      return places::fitSight(sight, moved.R(), moved.p, 0.002, false).r;
    };
    const auto fit = places::fitSight(sight, T.R(), T.p, 0.002, true);
    ASSERT_TRUE(fit.usable);
    ASSERT_LT(fit.r.norm(), 1e-9);
    for (int k = 0; k < 6; ++k) {
      Eigen::Matrix<double, 6, 1> d = Eigen::Matrix<double, 6, 1>::Zero();
      d(k) = 1e-6;
      const Vec2 slope = (at(d) - at(-d)) / 2e-6;
      EXPECT_LT((slope - fit.J.col(k)).norm(), 2e-3 * fit.J.norm()) << forward << " " << k;
    }
  }
}

/// Six of ten points look like others, the two see the place from far apart, tilted, and believe to
/// be elsewhere in another W.
TEST(VerifyLoop, FindsThePoseAmongSixtyPercentWrongMatches) {
  int found = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    MadeWorld world(900, seed);
    const Pose a = standing(Vec3(0, 0, 0), 0, 0.1, -0.15);
    const Pose b = standing(Vec3(0.8, -0.6, 0.3), 0.35, -0.2, 0.4);
    world.outliers = 0;
    const auto older = world.see(1, 0, a);
    world.outliers = 0.6;
    // Another W: turned about the vertical and shifted.
    const Pose T_V_W(Quat(rotZ(2.0)), Vec3(50, -20, 3));
    const auto newer = world.see(9, 100, b, T_V_W * b);
    places::VerifyOptions o;
    o.min_share = o.min_share_known = 0.1;
    o.min_inliers = 20;
    o.focal_px = 450;
    const LoopVerdict v = verifyLoop(*newer, Older{older}, o);
    if (!v.loop) continue;
    ++found;
    const Pose truth = a.inverse() * b;
    EXPECT_LT(distanceTo(v, truth), 0.06) << seed;
    EXPECT_LT(turnTo(v, truth), 0.015) << seed;
    EXPECT_EQ(v.loop->older, 1U);
    EXPECT_EQ(v.loop->newer, 9U);
    EXPECT_GE(v.loop->inliers, o.min_inliers);
    EXPECT_GE(v.loop->matches, v.loop->inliers / 2);
  }
  EXPECT_GE(found, 19);
}

TEST(VerifyLoop, DistancesOfOneSideAreEnough) {
  for (const bool of_older : {true, false}) {
    MadeWorld world(900, 4);
    const Pose a = standing(Vec3::Zero(), 0), b = standing(Vec3(0.4, 0.5, -0.2), -0.2, 0.1);
    world.known = of_older ? 1 : 0;
    const auto older = world.see(1, 0, a);
    world.known = of_older ? 0 : 1;
    const auto newer = world.see(2, 100, b);
    const LoopVerdict v = verifyLoop(*newer, Older{older});
    ASSERT_TRUE(v.loop) << of_older << ": " << name(v.refusal);
    EXPECT_LT(distanceTo(v, a.inverse() * b), 0.04) << of_older;
    EXPECT_LT(turnTo(v, a.inverse() * b), 0.01) << of_older;
  }
}

/// The covariance says how far off the pose is: 200 places, with neighbours that see the same
/// corners once more.
TEST(VerifyLoop, CovarianceIsHonest) {
  places::VerifyOptions o;
  o.focal_px = 450;
  o.bias_px = o.scale_sigma = 0;  // here nothing is off for all points together
  double sum = 0, sum_position = 0;
  int n = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    MadeWorld world(700, seed);
    Random random(seed, 9);
    const auto any = [&](double s) { return s * random.normal(); };
    const Pose a = standing(Vec3(any(0.3), any(0.3), any(0.2)), any(1), any(0.1), any(0.1));
    const Pose b = a * standing(Vec3(any(0.4), any(0.4), any(0.2)), any(0.2), any(0.05), any(0.05));
    const auto tilted = [&](const Pose& T) {
      return Pose(Quat(expQuat(Vec3(any(0.005), any(0.005), 0)) * T.q), T.p);
    };
    const Pose near = a * standing(Vec3(0.1, 0.15, 0), 0.02);
    const Pose believed = tilted(a);
    const Older older{world.see(1, 0, a, believed),
                      world.see(2, 0.3, near, believed * (a.inverse() * near))};
    const LoopVerdict v = verifyLoop(*world.see(9, 100, b, tilted(b)), older, o);
    if (!v.loop) continue;
    ++n;
    const double nees = places::loopChi2(*v.loop, {a.inverse() * b, Mat6::Zero()});
    sum += nees;
    const Vec3 e = v.loop->T_older_newer.p - (a.inverse() * b).p;
    const Mat3 C = v.loop->covariance.topLeftCorner<3, 3>();
    sum_position += e.dot(C.inverse() * e);
  }
  ASSERT_GE(n, 190);
  // Six and three degrees of freedom: careful, but not by more than a factor of three.
  EXPECT_LT(sum / n, 7.5);
  EXPECT_GT(sum / n, 2);
  EXPECT_LT(sum_position / n, 4);
  EXPECT_GT(sum_position / n, 1);
}

TEST(VerifyLoop, AnotherPlaceIsRefused) {
  int few = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    MadeWorld one(700, seed), other(700, seed + 1000);
    const LoopVerdict v = verifyLoop(*other.see(9, 100, Pose()), Older{one.see(1, 0, Pose())});
    EXPECT_FALSE(v.loop) << seed;
    few += v.refusal == LoopRefusal::few_matches;
  }
  EXPECT_EQ(few, 40);
}

/// Half of the points are those of the older place, the rest says that it is another.
TEST(VerifyLoop, APlaceThatSharesAPartOnlyIsRefused) {
  MadeWorld one(700, 3), other(700, 4);
  const std::size_t shared = other.points.size() / 8;
  std::copy_n(one.points.begin(), shared, other.points.begin());
  const auto older = one.see(1, 0, Pose()), newer = other.see(9, 100, Pose());
  places::VerifyOptions o;
  o.min_inliers = o.min_inliers_known = 8;
  o.min_matches = 8;
  const LoopVerdict v = verifyLoop(*newer, Older{older}, o);
  EXPECT_FALSE(v.loop);
  EXPECT_EQ(v.refusal, LoopRefusal::few_inliers);
  EXPECT_GE(v.inliers, 8);
  EXPECT_LT(v.share, 0.25);
}

TEST(VerifyLoop, PointsInOneCornerAreRefused) {
  MadeWorld world(30000, 3);
  std::vector<vir_test::MadePoint> corner;
  for (const auto& p : world.points) {
    if (std::abs(p.p_W.y() / p.p_W.x() - 0.4) < 0.09 && std::abs(p.p_W.z() / p.p_W.x()) < 0.09 &&
        p.p_W.x() > 0) {
      corner.push_back(p);
    }
  }
  world.points = corner;
  const auto older = world.see(1, 0, Pose()), newer = world.see(9, 100, Pose());
  ASSERT_GT(newer->points.size(), 40U);
  const LoopVerdict v = verifyLoop(*newer, Older{older});
  EXPECT_FALSE(v.loop);
  EXPECT_EQ(v.refusal, LoopRefusal::narrow) << name(v.refusal);
}

TEST(VerifyLoop, OdometryAndRangesReferee) {
  MadeWorld world(700, 3);
  const Pose a, b = standing(Vec3(0.3, 0.2, 0), 0.1);
  const auto older = world.see(1, 0, a), newer = world.see(9, 100, b);
  RelativePrior prior;
  prior.T_older_newer = a.inverse() * b;
  prior.covariance = 0.01 * Mat6::Identity();
  const LoopVerdict agrees = verifyLoop(*newer, Older{older}, {}, &prior);
  ASSERT_TRUE(agrees.loop);
  EXPECT_LT(agrees.chi2, 1);
  prior.T_older_newer.p.x() += 1;  // ten sigmas
  const LoopVerdict against = verifyLoop(*newer, Older{older}, {}, &prior);
  EXPECT_FALSE(against.loop);
  EXPECT_EQ(against.refusal, LoopRefusal::against_prior);
  ASSERT_TRUE(against.found);
  EXPECT_NEAR(against.chi2, 100, 10);
  prior.covariance(0, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(verifyLoop(*newer, Older{older}, {}, &prior).loop);
}

/// A camera of half the resolution: what is a pixel there is two elsewhere.
TEST(VerifyLoop, KnowsThePixelsOfTheCameraItself) {
  MadeWorld world(700, 3);
  const auto older = world.see(1, 0, Pose());
  world.noise_rad *= 2.5;
  const auto newer = world.see(9, 100, standing(Vec3(0.3, 0.2, 0), 0.1));
  places::VerifyOptions fine, coarse;
  fine.sigma_px_unknown = coarse.sigma_px_unknown = 1;
  fine.focal_px = 900;
  const int too_strict = verifyLoop(*newer, Older{older}, fine).inliers;
  PlaceKeyframe half = *newer;
  for (PlacePoint& p : half.points) p.px *= 0.4f;
  const LoopVerdict v = verifyLoop(half, Older{older}, coarse);
  ASSERT_TRUE(v.loop);
  EXPECT_GT(v.inliers, 2 * too_strict);
}

/// Where odometry says that this must be the place, fewer corners are enough; a vague word is none.
TEST(VerifyLoop, AKnownPlaceNeedsFewerCorners) {
  MadeWorld world(700, 3);
  const auto older = world.see(1, 0, Pose());
  world.outliers = 0.5;
  const auto newer = world.see(9, 100, standing(Vec3(0.3, 0.2, 0), 0.1));
  places::VerifyOptions o;
  o.min_inliers = 150;
  RelativePrior prior;
  prior.T_older_newer = standing(Vec3(0.3, 0.2, 0), 0.1);
  EXPECT_EQ(verifyLoop(*newer, Older{older}, o).refusal, LoopRefusal::few_inliers);
  prior.covariance = Mat6::Identity();
  EXPECT_EQ(verifyLoop(*newer, Older{older}, o, &prior).refusal, LoopRefusal::few_inliers);
  prior.covariance *= 0.04;
  const LoopVerdict v = verifyLoop(*newer, Older{older}, o, &prior);
  EXPECT_TRUE(v.known);
  EXPECT_TRUE(v.loop);
}

TEST(VerifyLoop, SameInputSameLoop) {
  const auto once = [] {
    MadeWorld world(700, 3);
    world.outliers = 0.25;
    const auto older = world.see(1, 0, Pose());
    return verifyLoop(*world.see(9, 100, standing(Vec3(0.5, 0.2, 0), 0.2)), Older{older});
  };
  const LoopVerdict a = once(), b = once();
  ASSERT_TRUE(a.loop && b.loop);
  EXPECT_EQ(a.loop->T_older_newer.p, b.loop->T_older_newer.p);
  EXPECT_EQ(a.loop->T_older_newer.q.coeffs(), b.loop->T_older_newer.q.coeffs());
  EXPECT_EQ(a.loop->covariance, b.loop->covariance);
}

TEST(VerifyLoop, DamagedKeyframesAreRefused) {
  MadeWorld world(700, 3);
  const auto good = world.see(1, 0, Pose()), newer = world.see(9, 100, Pose());
  const auto refused = [](const PlaceKeyframe& a, const Older& b) {
    return verifyLoop(a, b).refusal == LoopRefusal::few_matches;
  };
  const PlaceKeyframe empty;
  EXPECT_TRUE(refused(empty, Older{good}));
  EXPECT_TRUE(refused(*newer, Older{}));
  EXPECT_TRUE(refused(*newer, Older{nullptr}));
  EXPECT_TRUE(refused(*newer, Older{std::make_shared<PlaceKeyframe>()}));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  // Every ray, every distance, the pose, every descriptor the same.
  PlaceKeyframe bad = *newer;
  for (PlacePoint& p : bad.points) p.ray_C.x() = nan;
  EXPECT_TRUE(refused(bad, Older{good}));
  bad = *newer;
  bad.T_W_B.p.x() = nan;
  EXPECT_TRUE(refused(bad, Older{good}));
  bad = *newer;
  for (PlacePoint& p : bad.points) p.descriptor.fill(0x5A);
  EXPECT_TRUE(refused(bad, Older{std::make_shared<PlaceKeyframe>(bad)}));
  bad = *newer;
  for (PlacePoint& p : bad.points) {
    p.inverse_distance = std::numeric_limits<float>::infinity();
    p.inverse_distance_sigma = nan;
  }
  EXPECT_TRUE(refused(bad, Older{std::make_shared<PlaceKeyframe>(bad)}));
  // Some damaged points among good ones are passed over.
  bad = *newer;
  for (std::size_t k = 0; k < bad.points.size(); k += 4) bad.points[k].ray_C.setConstant(nan);
  const LoopVerdict v = verifyLoop(bad, Older{good, nullptr});
  ASSERT_TRUE(v.loop);
  EXPECT_LT(v.loop->T_older_newer.p.norm(), 0.03);
}

TEST(VerifyLoop, RefusesOptionsThatAreNone) {
  places::VerifyOptions o;
  o.focal_px = -1;
  const PlaceKeyframe k;
  EXPECT_THROW(verifyLoop(k, {}, o), std::invalid_argument);
}

}  // namespace
