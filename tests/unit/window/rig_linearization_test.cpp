/// Sights between two cameras of a rig: their own way into the normal equations against the
/// factor's Jacobians multiplied out.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <deque>
#include <map>

#include "linearization.h"
#include "vir/core/random.h"
#include "vir/factors/pose_manifold.h"

namespace vir::window {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using factors::kCameraParameters;

/// Three frames, two cameras, and landmarks that either of them hosts.
class RigTerms {
 public:
  explicit RigTerms(bool first_estimates) {
    for (int k = 0; k < 3; ++k) {
      factors::poseTo(somePose(0.3), poses_[k]);
      factors::poseTo(somePose(0.3), lin_[k]);
    }
    for (int c = 0; c < 2; ++c) {
      factors::poseTo(somePose(0.1), extrinsics_[c]);
      for (double& p : parameters_[c]) p = 1e-3 * random_.normal();
    }
    for (int l = 0; l < 6; ++l) addLandmark(l % 2, l % 3, first_estimates);
    // The further camera before the first, as a window has them.
    for (double* pose : {poses_[0], poses_[1], poses_[2]}) order.push_back({pose, 7, 0, nullptr});
    for (const int c : {1, 0}) {
      order.push_back({extrinsics_[c], 7, 0, nullptr});
      order.push_back({parameters_[c], kCameraParameters, 0, nullptr});
    }
  }

  std::vector<Term> terms;
  std::vector<BlockRef> order;

 private:
  Vec3 someVector(double size) {
    const double x = random_.normal(), y = random_.normal(), z = random_.normal();
    return size * Vec3(x, y, z);
  }
  Pose somePose(double size) { return {expQuat(someVector(size)), someVector(size)}; }
  void fill(factors::CameraRay* ray) {
    ray->bearing = (Vec3(0, 0, 1) + someVector(0.2)).normalized();
    for (int k = 0; k < kCameraParameters; ++k) ray->by_camera.col(k) = someVector(0.5);
  }
  void addLandmark(int camera, int frame, bool first_estimates) {
    hosts_.emplace_back();
    factors::HostRay& host = hosts_.back();
    fill(&host);
    host.basis = factors::tangentBasis(host.bearing);
    values_.push_back({0.01, -0.02, 0.4});
    double* x = values_.back().data();
    for (int f = 0; f < 3; ++f) {
      sights_.emplace_back();
      fill(&sights_.back());
      for (int k = 0; k < 3; ++k) sights_.back().weight.col(k) = 100 * someVector(1).head<2>();
      const bool same = f == frame;
      factors_.emplace_back();
      factors_.back().set(host, sights_.back(), same, nullptr,
                          first_estimates ? lin_[frame] : nullptr,
                          first_estimates ? lin_[f] : nullptr);
      BlockList blocks{x};
      if (!same) {
        blocks.add(poses_[frame]);
        blocks.add(poses_[f]);
      }
      for (const int c : {camera, 1 - camera}) {
        blocks.add(extrinsics_[c]);
        blocks.add(parameters_[c]);
      }
      terms.push_back({&factors_.back(), std::move(blocks), 0, false, x});
    }
  }

  Random random_{5, 21};
  double poses_[3][7], lin_[3][7], extrinsics_[2][7], parameters_[2][kCameraParameters];
  std::deque<factors::HostRay> hosts_;
  std::deque<factors::Sight> sights_;
  std::deque<factors::RigReprojectionFactor> factors_;
  std::deque<std::array<double, 3>> values_;
};

void expectAsMultipliedOut(bool first_estimates) {
  const RigTerms rig(first_estimates);
  TermLayout layout;
  layout.build(rig.terms, rig.order);
  for (const TermLayout::Entry& e : layout.entries()) {
    ASSERT_NE(e.shape, TermShape::any_of_landmark) << "not what is tested here";
  }
  Linearization lin;
  lin.linearize(layout);

  std::map<const double*, int> column;
  for (const BlockRef& b : layout.blocks()) column[b.data] = b.offset;
  const int n = layout.size(), landmarks = static_cast<int>(layout.landmarks().size());
  for (int l = 0; l < landmarks; ++l) {
    column[layout.landmarks()[static_cast<std::size_t>(l)].x] = n + 3 * l;
  }
  MatrixXd J = MatrixXd::Zero(2 * static_cast<int>(rig.terms.size()), n + 3 * landmarks);
  VectorXd r(J.rows());
  for (std::size_t t = 0; t < rig.terms.size(); ++t) {
    const Term& term = rig.terms[t];
    const auto& sizes = term.cost->parameter_block_sizes();
    std::vector<std::vector<double>> raw;
    std::vector<double*> pointers;
    for (const int size : sizes) raw.emplace_back(2 * static_cast<std::size_t>(size));
    for (auto& one : raw) pointers.push_back(one.data());
    const int row = 2 * static_cast<int>(t);
    ASSERT_TRUE(term.cost->Evaluate(term.blocks.data(), r.data() + row, pointers.data()));
    for (std::size_t k = 0; k < sizes.size(); ++k) {
      using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
      const int local = sizes[k] == 7 ? 6 : sizes[k];
      J.block(row, column.at(term.blocks[k]), 2, local) +=
          Eigen::Map<const RowMajor>(raw[k].data(), 2, sizes[k]).leftCols(local);
    }
  }
  const MatrixXd H = J.transpose() * J;
  const VectorXd b = J.transpose() * r;
  const double scale = H.norm();
  const MatrixXd difference = lin.H() - H.topLeftCorner(n, n);
  EXPECT_LT(MatrixXd(difference.triangularView<Eigen::Upper>()).norm(), 1e-12 * scale);
  EXPECT_LT((lin.b() - b.head(n)).norm(), 1e-12 * b.norm());
  EXPECT_NEAR(lin.sums().cost, 0.5 * r.squaredNorm(), 1e-12 * r.squaredNorm());
  EXPECT_NEAR(evaluate(layout).cost, lin.sums().cost, 1e-12 * r.squaredNorm());
  for (int l = 0; l < landmarks; ++l) {
    const auto at = static_cast<std::size_t>(l);
    const int c = n + 3 * l;
    EXPECT_LT((lin.own(at).H - H.block<3, 3>(c, c)).norm(), 1e-12 * scale);
    EXPECT_LT((lin.own(at).b - b.segment<3>(c)).norm(), 1e-12 * b.norm());
    const TermLayout::LandmarkTerms& of = layout.landmarks()[at];
    MatrixXd coupling = MatrixXd::Zero(n, 3);
    for (int k = of.first_slot; k < of.first_slot + of.slots; ++k) {
      const TermLayout::Slot& s = layout.slot(k);
      coupling.middleRows(s.offset, s.size) = lin.coupling(k).topRows(s.size);
    }
    EXPECT_LT((coupling - H.block(0, c, n, 3)).norm(), 1e-12 * scale);
  }
}

TEST(RigLinearization, IsTheFactorsJacobiansMultipliedOut) { expectAsMultipliedOut(false); }

TEST(RigLinearization, JacobiansAreTakenAtFirstEstimates) { expectAsMultipliedOut(true); }

}  // namespace
}  // namespace vir::window
