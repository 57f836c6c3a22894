#include "vir/window/marginalization.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "linearization.h"
#include "vir/factors/pose_manifold.h"

namespace vir::window {
namespace {
/// Pivots of a matrix of full rank are larger than the eigenvalues that count as none by this.
constexpr double kSafely = 1e3;

void blockMinus(const double* y, const double* x, int ambient, double* delta) {
  if (ambient == 7) {
    factors::poseMinus(y, x, delta);
  } else {
    for (int i = 0; i < ambient; ++i) delta[i] = y[i] - x[i];
  }
}

Eigen::MatrixXd scaledPseudoInverse(const Eigen::MatrixXd& H, double relative) {
  // Of a denormal number the inverse would be infinite.
  constexpr double kLeast = std::numeric_limits<double>::min();
  const Eigen::VectorXd s =
      H.diagonal().unaryExpr([](double d) { return d >= kLeast ? 1.0 / std::sqrt(d) : 0.0; });
  const Eigen::MatrixXd A = s.asDiagonal() * H * s.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eig(A);
  const Eigen::VectorXd inv =
      eig.eigenvalues().unaryExpr([&](double l) { return l > relative ? 1.0 / l : 0.0; });
  const Eigen::MatrixXd V = s.asDiagonal() * eig.eigenvectors();
  return V * inv.asDiagonal() * V.transpose();
}

}  // namespace

int NormalEquations::offsetOf(const double* block) const {
  for (const BlockRef& ref : blocks) {
    if (ref.data == block) return ref.offset;
  }
  return -1;
}

NormalEquations eliminateLandmarks(const std::vector<Term>& terms,
                                   const std::vector<BlockRef>& order) {
  TermLayout layout;
  layout.build(terms, order);
  Linearization lin;
  lin.linearize(layout);
  NormalEquations eq;
  eq.blocks = layout.blocks();
  eq.H = lin.H();
  eq.b = lin.b();
  eliminateLandmarks(layout, lin, &eq.H, &eq.b);
  eq.H.triangularView<Eigen::StrictlyLower>() = eq.H.transpose();
  return eq;
}

NormalEquations marginalizeFirst(const NormalEquations& full, int count) {
  int m = 0;
  for (int k = 0; k < count; ++k) m += full.blocks[k].local();
  const int n = static_cast<int>(full.H.rows()) - m;
  const Eigen::MatrixXd inv = scaledPseudoInverse(full.H.topLeftCorner(m, m), 1e-12);
  const Eigen::MatrixXd W = full.H.bottomLeftCorner(n, m) * inv;
  NormalEquations out;
  out.H = full.H.bottomRightCorner(n, n) - W * full.H.topRightCorner(m, n);
  out.H = 0.5 * (out.H + out.H.transpose()).eval();
  out.b = full.b.tail(n) - W * full.b.head(m);
  for (std::size_t k = count; k < full.blocks.size(); ++k) {
    out.blocks.push_back(full.blocks[k]);
    out.blocks.back().offset -= m;
  }
  return out;
}

void addProcessNoise(int column, double variance, NormalEquations* eq) {
  // (H^-1 + variance e e^T)^-1, and the minimum stays where it is.
  const Eigen::VectorXd h = eq->H.col(column);
  const double gain = variance / (1 + variance * h[column]);
  const double b = eq->b[column];
  eq->H -= gain * h * h.transpose();
  eq->b -= gain * b * h;
}

namespace {

/// Directions of which nothing is known are left out. The few that might be such are what is left
/// of A after its large pivots; only there its eigenvalues are looked for, by Rayleigh's quotient
/// of the whole direction.
void rootByPivots(const Eigen::MatrixXd& A, const Eigen::VectorXd& s, const Eigen::VectorXd& b,
                  double relative, factors::LinearPrior* prior) {
  const Eigen::LDLT<Eigen::MatrixXd> ldlt(A);
  const auto n = A.rows();
  const Eigen::VectorXd D = ldlt.vectorD();
  Eigen::Index large = 0;
  while (large < n && D[large] > kSafely * relative) ++large;
  const auto few = n - large;
  const Eigen::MatrixXd L = ldlt.matrixL();
  const auto L11 = L.topLeftCorner(large, large).triangularView<Eigen::UnitLower>();
  const auto L21 = L.bottomLeftCorner(few, large);
  const Eigen::MatrixXd L22 = L.bottomRightCorner(few, few);
  Eigen::MatrixXd left = L22 * D.tail(few).asDiagonal() * L22.transpose();
  left = 0.5 * (left + left.transpose()).eval();
  // With the others where the large pivots want them.
  const Eigen::MatrixXd others = L11.transpose().solve(L21.transpose());
  const Eigen::MatrixXd length = Eigen::MatrixXd::Identity(few, few) + others.transpose() * others;
  Eigen::VectorXd root = D.head(large).cwiseSqrt();
  Eigen::VectorXd y = ldlt.transpositionsP() * b;
  Eigen::VectorXd y1 = y.head(large);
  L11.solveInPlace(y1);
  const Eigen::VectorXd y2 = y.tail(few) - L21 * y1;

  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(n, n);
  J.topRows(large) = root.asDiagonal() * L.leftCols(large).transpose();
  prior->r0.resize(n);
  prior->r0.head(large) = y1.cwiseQuotient(root);
  auto rows = large;
  if (few > 0) {
    const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> eig(left, length);
    for (Eigen::Index k = 0; k < few; ++k) {
      const double l = eig.eigenvalues()[k];
      if (!(l > relative)) continue;
      const Eigen::VectorXd u = eig.eigenvectors().col(k);
      J.row(rows).tail(few) = std::sqrt(l) * (length * u).transpose();
      prior->r0[rows++] = u.dot(y2) / std::sqrt(l);
    }
  }
  const Eigen::MatrixXd Jt =
      ldlt.transpositionsP().transpose() * J.topRows(rows).transpose().eval();
  prior->J = Jt.transpose() * s.asDiagonal();
  prior->r0.conservativeResize(rows);
}

}  // namespace

factors::LinearPrior toPrior(const NormalEquations& eq, double relative) {
  // Scale first: positions, angles and biases differ by orders of magnitude in information.
  const Eigen::VectorXd s =
      eq.H.diagonal().unaryExpr([](double d) { return d > 0 ? std::sqrt(d) : 0.0; });
  const Eigen::VectorXd s_inv = s.unaryExpr([](double d) { return d > 0 ? 1.0 / d : 0.0; });
  const Eigen::MatrixXd A = s_inv.asDiagonal() * eq.H * s_inv.asDiagonal();
  factors::LinearPrior prior;
  const int n = static_cast<int>(eq.H.rows());
  // The equations stand at the current values; the prior at the first estimates.
  Eigen::VectorXd shift = Eigen::VectorXd::Zero(n);
  for (const BlockRef& ref : eq.blocks) {
    if (ref.lin) blockMinus(ref.data, ref.lin, ref.ambient, shift.data() + ref.offset);
  }
  const Eigen::VectorXd b = s_inv.asDiagonal() * (eq.b - eq.H * shift);
  // Where everything is known the factor of Cholesky is a square root as good as any.
  const Eigen::LLT<Eigen::MatrixXd> llt(A);
  const bool full_rank = llt.info() == Eigen::Success &&
                         llt.matrixLLT().diagonal().cwiseAbs2().minCoeff() > kSafely * relative;
  if (full_rank) {
    prior.J = llt.matrixU();
    prior.J *= s.asDiagonal();
    prior.r0 = llt.matrixL().solve(b);
  } else {
    rootByPivots(A, s, b, relative, &prior);
  }
  for (const BlockRef& ref : eq.blocks) {
    factors::LinearPrior::Block block;
    block.ambient = ref.ambient;
    block.offset = ref.offset;
    const double* x0 = ref.lin ? ref.lin : ref.data;
    block.x0.assign(x0, x0 + ref.ambient);
    prior.blocks.push_back(block);
  }
  return prior;
}

Eigen::MatrixXd covarianceOf(const NormalEquations& eq, double relative) {
  return scaledPseudoInverse(eq.H, relative);
}

}  // namespace vir::window
