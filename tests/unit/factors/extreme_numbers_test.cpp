/// Numbers that are no measurements in each place of each factor: what is written is numbers as
/// long as what is read is some that can be squared, and nothing is written elsewhere.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>

#include "vir/factors/drift_edge_factor.h"
#include "vir/factors/head_range_factor.h"
#include "vir/factors/imu_factor.h"
#include "vir/factors/linear_prior_factor.h"
#include "vir/factors/motion_factors.h"
#include "vir/factors/mutual_range_factor.h"
#include "vir/factors/node_edge_factor.h"
#include "vir/factors/node_range_difference_factor.h"
#include "vir/factors/node_range_factor.h"
#include "vir/factors/position_link_factor.h"
#include "vir/factors/range_factor.h"
#include "vir/factors/reprojection_factor.h"
#include "vir/factors/window_range_factor.h"
#include "vir_test_extremes.h"
#include "vir_test_jacobian.h"

namespace vir::factors {
namespace {

using test::extremes;
using vir_test::Blocks;
using vir_test::RowMajor;

/// Beyond, squares are infinite, and a sum of them says nothing.
constexpr double kSquarable = 1e18;
/// exp() of less than that is a scale.
constexpr double kLargestLogScale = 300;

bool sensible(double x) { return std::isfinite(x) && std::abs(x) <= kSquarable; }

const Blocks& usual() {
  static const Blocks blocks{{1, 2, 3, 0, 0, std::sin(0.2), std::cos(0.2)},  // pose
                             {-2, 1, 0.5, std::sin(0.1), 0, 0, std::cos(0.1)},
                             {0.1, 0.2, 0.3, 0.01, 0.02, -0.01, 0.1, -0.1, 0.05},  // speed, biases
                             {0.5, -1, 2, 0.3, 0.1},                               // node
                             {3, 4, 5, 0.1},                                       // anchor
                             {0.01, -0.02, 0.3},                                   // landmark
                             {0.001, 0, 0.01, 0, 1, -1, 0.1, 0.2},                 // camera
                             std::vector<double>(imu::kImuIntrinsicsSize, 0.001),
                             {0.02, -0.01}};  // centre, drift of the heading
  return blocks;
}

/// Of usual().
enum Which { kPose, kOther, kSpeed, kNode, kAnchor, kLandmark, kCamera, kIntrinsics, kTwo };

void evaluate(const ceres::CostFunction& f, const Blocks& x, bool numbers,
              const std::string& what) {
  SCOPED_TRACE(what);
  Eigen::VectorXd r = Eigen::VectorXd::Zero(f.num_residuals());
  std::vector<RowMajor> J;
  std::vector<double*> p;
  for (const std::vector<double>& block : x) {
    J.push_back(RowMajor::Zero(f.num_residuals(), static_cast<int>(block.size())));
  }
  for (RowMajor& j : J) p.push_back(j.data());
  const bool valid = f.Evaluate(vir_test::pointers(x).data(), r.data(), p.data());
  if (!valid || !numbers) return;
  EXPECT_TRUE(r.allFinite()) << r.transpose();
  for (const RowMajor& j : J) EXPECT_TRUE(j.allFinite()) << j;
}

/// `of`: the blocks that it takes.
void tryAll(const ceres::CostFunction& f, const std::vector<Which>& of, const std::string& name) {
  Blocks x;
  for (const Which w : of) x.push_back(usual()[w]);
  vir_test::requireBlocksOf(f, x);
  for (std::size_t b = 0; b < x.size(); ++b) {
    for (std::size_t i = 0; i < x[b].size(); ++i) {
      const double before = x[b][i];
      const bool log_scale = of[b] == kNode && i == 4;
      for (const double value : extremes()) {
        x[b][i] = value;
        const bool numbers = log_scale ? std::abs(value) < kLargestLogScale : sensible(value);
        evaluate(f, x, numbers,
                 name + ", block " + std::to_string(b) + "[" + std::to_string(i) +
                     "] = " + std::to_string(value));
      }
      x[b][i] = before;
    }
  }
}

RangeTerm rangeOf(double range_m, double sigma_m) { return {range_m, sigma_m, {}}; }

TEST(ExtremeNumbers, WhereRobotsAndAnchorsAre) {
  const Vec3 a(0.1, 0.2, 0.3), b(0, 0, 0.1);
  const RangeTerm range = rangeOf(4, 0.1);
  tryAll(NodeRangeFactor(range, a, b), {kNode, kAnchor}, "node range");
  tryAll(NodeRangeDifferenceFactor(range, a, b), {kNode, kAnchor, kAnchor}, "difference");
  tryAll(HeadRangeFactor(range, a, b), {kPose, kNode, kAnchor}, "head range");
  tryAll(WindowRangeFactor(range, a, b), {kPose, kOther, kNode, kAnchor}, "window range");
  const AntennaAtNode first{a, b, AntennaAtNode::Axes::Identity()};
  tryAll(MutualRangeFactor(range, first, {b, a}), {kNode, kNode, kTwo, kTwo}, "mutual range");
  tryAll(CentredRangeFactor(range, first), {kNode, kAnchor, kTwo}, "centred range");
  tryAll(PositionLinkFactor(a, 100), {kNode, kNode}, "link");
  tryAll(NodeEdgeFactor(a, Eigen::Matrix4d::Identity(), 0.01), {kNode, kNode}, "edge");
  tryAll(DriftEdgeFactor(a, Eigen::Matrix4d::Identity(), 0.01, 2, 0.5), {kNode, kNode, kTwo},
         "drifting edge");
  tryAll(ZeroVelocityFactor(0.01), {kSpeed}, "rest");
  tryAll(RelativePoseFactor(Pose(), Eigen::Matrix<double, 6, 6>::Identity()), {kPose, kOther},
         "relative pose");
}

TEST(ExtremeNumbers, MeasuredRanges) {
  const Blocks x{usual()[kNode], usual()[kAnchor]};
  const Vec3 none = Vec3::Zero();
  for (const double value : extremes()) {
    const std::string text = std::to_string(value);
    evaluate(NodeRangeFactor(rangeOf(value, 0.1), none, none), x, sensible(value), "range " + text);
    test::forExtremeVectors(Vec3(0.1, 0.2, 0.3), [&](const Vec3& v) {
      const bool numbers = sensible(v.cwiseAbs().maxCoeff()) && v.allFinite();
      evaluate(NodeRangeFactor(rangeOf(4, 0.1), v, none), x, numbers, "motion");
      evaluate(NodeRangeFactor(rangeOf(4, 0.1), none, v), x, numbers, "lever");
    });
    if (!sensible(value)) continue;
    const RangePrediction p = predictRange(Vec3::Constant(value), Vec3(1, 2, 3), 0, 1);
    EXPECT_TRUE(p.direction.allFinite() && std::isfinite(p.value_m)) << text;
  }
  // At the anchor itself there is no direction, and no NaN.
  const RangePrediction at = predictRange(Vec3(1, 2, 3), Vec3(1, 2, 3), 0, 1);
  EXPECT_EQ(at.value_m, -1);
  EXPECT_EQ(at.direction, Vec3::Zero());
}

TEST(ExtremeNumbers, ImuLinks) {
  imu::Preintegration link(imu::ImuNoise(), Vec3::Zero(), Vec3::Zero());
  for (int k = 0; k < 20; ++k) {
    const auto at = [](int i) {
      return ImuSample{i * 5'000'000LL, Vec3(0.1, 0.02, 0), Vec3(0, 0.1, 9.81)};
    };
    link.integrate(at(k), at(k + 1));
  }
  tryAll(ImuFactor(link, 9.81), {kPose, kSpeed, kOther, kSpeed}, "imu");
  tryAll(ImuCalibrationFactor(link, 9.81), {kPose, kSpeed, kOther, kSpeed, kIntrinsics},
         "imu with intrinsics");
}

Sight sightOf(const Vec3& bearing) {
  Sight s;
  s.bearing = bearing;
  s.weight << 400, 0, 0, 0, 400, 0;
  return s;
}

TEST(ExtremeNumbers, Sights) {
  HostRay host;
  host.bearing = Vec3(0.1, 0.2, 1).normalized();
  host.basis = tangentBasis(host.bearing);
  const Sight sight = sightOf(Vec3(0.05, 0.1, 1).normalized());
  const ReprojectionFactor plain(host, sight, Pose(), CameraVector::Zero());
  const ReprojectionCalibrationFactor calibrated(host, sight);
  tryAll(plain, {kPose, kOther, kLandmark}, "sight");
  tryAll(calibrated, {kPose, kOther, kPose, kLandmark, kCamera}, "sight with calibration");
  tryAll(PointSightFactor(Vec3(1, 2, 5), sight, Pose()), {kPose}, "point");
  tryAll(HostSightFactor(host, sight.weight), {kLandmark}, "host");
  // A landmark in the very centre of the camera that sees it.
  Blocks x{usual()[kPose], usual()[kPose], {0, 0, INFINITY}};
  evaluate(plain, x, false, "landmark in the camera");
  evaluate(PointSightFactor(Vec3(1, 2, 3), sight, Pose()), {usual()[kPose]}, true,
           "point in the camera");
}

/// Whatever a unit vector is meant to be: two that are orthogonal, or no numbers.
TEST(ExtremeNumbers, TangentPlanes) {
  test::forExtremeVectors(Vec3(0, 0, 1), [](const Vec3& v) {
    const Mat32 basis = tangentBasis(v.normalized());
    if (!v.normalized().allFinite() || std::abs(v.normalized().norm() - 1) > 1e-9) return;
    EXPECT_LT((basis.transpose() * basis - Eigen::Matrix2d::Identity()).norm(), 1e-9);
    EXPECT_LT((basis.transpose() * v.normalized()).norm(), 1e-9);
  });
}

TEST(ExtremeNumbers, Priors) {
  LinearPrior prior;
  prior.blocks = {{7, 0, usual()[kPose]}, {9, 6, usual()[kSpeed]}};
  prior.J = Eigen::MatrixXd::Identity(15, 15);
  prior.r0 = Eigen::VectorXd::Zero(15);
  const LinearPriorFactor factor(prior);
  tryAll(factor, {kPose, kSpeed}, "prior");
  for (const double value : extremes()) {
    Blocks x{usual()[kPose], usual()[kSpeed]};
    x[1][4] = value;
    Eigen::MatrixXd H;
    Eigen::VectorXd b;
    double squared = 0;
    factor.linearize(vir_test::pointers(x).data(), &H, &b, &squared);
    EXPECT_EQ(H.rows(), 15);
    EXPECT_TRUE(H.allFinite());
    EXPECT_TRUE(!sensible(value) || (b.allFinite() && std::isfinite(squared))) << value;
  }
}

/// What a pose becomes by a step, and the step between two.
TEST(ExtremeNumbers, StepsOfPoses) {
  for (const double value : extremes()) {
    for (int i = 0; i < 6; ++i) {
      double delta[6] = {0.1, 0.2, 0.3, 0.01, 0.02, 0.03}, y[7];
      delta[i] = value;
      posePlus(usual()[kPose].data(), delta, y);
      if (!sensible(value)) continue;
      const Pose moved = poseFrom(y);
      EXPECT_TRUE(moved.p.allFinite()) << value;
      EXPECT_NEAR(moved.q.norm(), 1, 1e-9) << value;
      double back[6];
      poseMinus(y, usual()[kPose].data(), back);
      for (const double d : back) EXPECT_TRUE(std::isfinite(d)) << value;
    }
  }
}

}  // namespace
}  // namespace vir::factors
