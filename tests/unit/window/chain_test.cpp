#include "chain.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cstdint>
#include <vector>

#include "vir/core/random.h"

namespace vir::window {
namespace {

using RowMat5 = Eigen::Matrix<double, 5, 5, Eigen::RowMajor>;
using RowMat54 = Eigen::Matrix<double, 5, 4, Eigen::RowMajor>;

template <typename Matrix>
Matrix drawn(Random* random) {
  Matrix m;
  for (int i = 0; i < m.size(); ++i) m.data()[i] = random->uniform(-1, 1);
  return m;
}

/// A chain of nodes, each tied to the next `band` and to both anchors: eliminated node by node, and
/// all at once.
void expectAsAllAtOnce(int band) {
  constexpr int kNodes = 6, kAnchors = 2;
  const int n = kNodeSize * (kNodes + band) + kAnchorSize * kAnchors;
  const int first_anchor = kNodeSize * (kNodes + band);
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(n);
  Frontal f(band, kAnchors);
  std::vector<EliminatedNode> gone(kNodes);
  Random random(7, static_cast<std::uint64_t>(band));
  for (int k = 0; k < kNodes; ++k) {
    const auto add = [&](int ahead, int anchor) {
      const Vec5 e = drawn<Vec5>(&random);
      const RowMat5 J = drawn<RowMat5>(&random);
      const auto both = [&](const auto& other, int in_frontal, int in_all) {
        f.add(e, J, 0, other, in_frontal);
        Eigen::MatrixXd wide = Eigen::MatrixXd::Zero(5, n);
        wide.middleCols(kNodeSize * k, 5) = J;
        wide.middleCols(in_all, other.cols()) = other;
        H += wide.transpose() * wide;
        b += wide.transpose() * e;
      };
      if (anchor < 0) {
        both(drawn<RowMat5>(&random), f.nodeOffset(ahead), kNodeSize * (k + ahead));
      } else {
        both(drawn<RowMat54>(&random), f.anchorOffset(anchor), first_anchor + kAnchorSize * anchor);
      }
    };
    for (int ahead = 1; ahead <= band; ++ahead) add(ahead, -1);
    for (int anchor = 0; anchor < kAnchors; ++anchor) add(0, anchor);
    f.eliminateFirst(&gone[static_cast<std::size_t>(k)]);
  }
  f.mirror();
  // What is left: the next `band` nodes, a fresh one of zeros, the anchors.
  const int before = kNodeSize * kNodes, left = n - before, kept = kNodeSize * band;
  const Eigen::MatrixXd A = H.topLeftCorner(before, before), C = H.topRightCorner(before, left);
  const Eigen::MatrixXd S = H.bottomRightCorner(left, left) - C.transpose() * A.ldlt().solve(C);
  const Eigen::VectorXd s = b.tail(left) - C.transpose() * A.ldlt().solve(b.head(before));
  for (int i = 0; i < left; ++i) {
    const int at_i = i < kept ? i : i + kNodeSize;
    EXPECT_NEAR(f.b[at_i], s[i], 1e-9) << band;
    for (int j = 0; j < left; ++j) {
      const int at_j = j < kept ? j : j + kNodeSize;
      EXPECT_NEAR(f.H(at_i, at_j), S(i, j), 1e-9) << band << ' ' << i << ' ' << j;
    }
  }
  EXPECT_EQ(f.H.middleRows(kept, kNodeSize).cwiseAbs().maxCoeff(), 0);
  EXPECT_EQ(f.H.middleCols(kept, kNodeSize).cwiseAbs().maxCoeff(), 0);
  // The last node follows what is left.
  const Eigen::VectorXd moved = Eigen::VectorXd::LinSpaced(left, -1, 1);
  const Eigen::VectorXd all = -A.ldlt().solve(b.head(before) + C * moved);
  EXPECT_LT((gone.back().follow(moved) - all.tail<kNodeSize>()).norm(), 1e-9 * (1 + all.norm()));
}

TEST(Chain, EliminatedNodeByNodeAsAllAtOnce) {
  expectAsAllAtOnce(1);
  expectAsAllAtOnce(3);
}

TEST(Chain, WhatNothingIsKnownOfStays) {
  Frontal f(1, 0);
  f.H(0, 0) = 4;
  f.b[0] = 2;
  EliminatedNode gone;
  f.eliminateFirst(&gone);
  const Vec5 moved = gone.follow(Eigen::VectorXd::Ones(5));
  EXPECT_DOUBLE_EQ(moved[0], -0.5);
  EXPECT_EQ(moved.tail<4>().cwiseAbs().maxCoeff(), 0);
}

}  // namespace
}  // namespace vir::window
