#include "vir/window/marginalization.h"

#include <ceres/cost_function.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "vir/factors/camera_parameters.h"
#include "vir/factors/pose_manifold.h"

namespace vir::window {
namespace {
/// Pivots of a matrix of full rank are larger than the eigenvalues that count as none by this.
constexpr double kSafely = 1e3;

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Residual and local Jacobians of one term, robust weight applied. Buffers are reused.
class Linearizer {
 public:
  void evaluate(const Term& t) {
    const std::vector<int>& sizes = t.cost->parameter_block_sizes();
    rows = t.cost->num_residuals();
    r.resize(rows);
    J.resize(sizes.size());
    pointers_.resize(sizes.size());
    for (std::size_t k = 0; k < sizes.size(); ++k) {
      J[k].resize(rows, sizes[k]);
      pointers_[k] = J[k].data();
    }
    if (!t.cost->Evaluate(t.blocks.data(), r.data(), pointers_.data())) {
      throw std::runtime_error("marginalization: a residual could not be evaluated");
    }
    const double n = r.norm();
    if (t.robust > 0 && (t.cauchy || n > t.robust)) {
      const double w =
          t.cauchy ? 1.0 / std::sqrt(1.0 + n * n / (t.robust * t.robust)) : std::sqrt(t.robust / n);
      r *= w;
      for (RowMajor& j : J) j *= w;
    }
  }
  int rows = 0;
  Eigen::VectorXd r;
  std::vector<RowMajor> J;

 private:
  std::vector<double*> pointers_;
};

void blockMinus(const double* y, const double* x, int ambient, double* delta) {
  if (ambient == 7) {
    factors::poseMinus(y, x, delta);
  } else {
    for (int i = 0; i < ambient; ++i) delta[i] = y[i] - x[i];
  }
}

int localSize(int ambient) { return ambient == 7 ? 6 : ambient; }

Eigen::MatrixXd scaledPseudoInverse(const Eigen::MatrixXd& H, double relative) {
  const Eigen::VectorXd s =
      H.diagonal().unaryExpr([](double d) { return d > 0 ? 1.0 / std::sqrt(d) : 0.0; });
  const Eigen::MatrixXd A = s.asDiagonal() * H * s.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eig(A);
  const Eigen::VectorXd inv =
      eig.eigenvalues().unaryExpr([&](double l) { return l > relative ? 1.0 / l : 0.0; });
  const Eigen::MatrixXd V = s.asDiagonal() * eig.eigenvectors();
  return V * inv.asDiagonal() * V.transpose();
}

/// The same for a landmark, in closed form where it is well observed.
Mat3 scaledPseudoInverse3(const Mat3& H) {
  const Vec3 s = H.diagonal().unaryExpr([](double d) { return d > 0 ? 1.0 / std::sqrt(d) : 0.0; });
  const Mat3 A = s.asDiagonal() * H * s.asDiagonal();
  // Its diagonal is one: the determinant is below the product of the two larger eigenvalues (at
  // most 9/4) times the smallest.
  const double determinant = A.determinant();
  if (determinant > 1e-6) return s.asDiagonal() * A.inverse() * s.asDiagonal();
  return scaledPseudoInverse(H, 1e-9);
}

/// Normal equations of one landmark: its own 3x3 block and the coupling to the blocks it touches.
struct LandmarkSystem {
  Mat3 H = Mat3::Zero();
  Vec3 b = Vec3::Zero();
  std::vector<int> offsets, sizes;
  std::vector<int> columns;  // scratch: of the term at hand
  // The largest block that a sight touches.
  static constexpr int kWidest = std::max(6, factors::kCameraParameters);
  using Coupling = Eigen::Matrix<double, kWidest, 3>;
  std::vector<Coupling> coupling;  // H_xl per touched block, first `size` rows

  void reset() {
    H.setZero();
    b.setZero();
    offsets.clear();
    sizes.clear();
    coupling.clear();
  }
  int slot(int offset, int size) {
    for (std::size_t k = 0; k < offsets.size(); ++k) {
      if (offsets[k] == offset) return static_cast<int>(k);
    }
    if (size > kWidest) throw std::logic_error("marginalization: a sight touches a wider block");
    offsets.push_back(offset);
    sizes.push_back(size);
    coupling.push_back(Coupling::Zero());
    return static_cast<int>(offsets.size()) - 1;
  }
  /// Only what lies on and above the diagonal of H is brought up to date.
  void eliminateFrom(NormalEquations* eq) const {
    const Mat3 inv = scaledPseudoInverse3(H);
    for (std::size_t i = 0; i < offsets.size(); ++i) {
      const Coupling W = coupling[i] * inv;
      const Eigen::Matrix<double, kWidest, 1> Wb = W * b;
      eq->b.segment(offsets[i], sizes[i]) -= Wb.head(sizes[i]);
      for (std::size_t j = 0; j < offsets.size(); ++j) {
        if (offsets[j] < offsets[i]) continue;
        if (sizes[i] == 6 && sizes[j] == 6) {
          eq->H.block<6, 6>(offsets[i], offsets[j]).noalias() -=
              W.topRows<6>() * coupling[j].topRows<6>().transpose();
        } else {
          const Eigen::Matrix<double, kWidest, kWidest> S = W * coupling[j].transpose();
          eq->H.block(offsets[i], offsets[j], sizes[i], sizes[j]) -=
              S.topLeftCorner(sizes[i], sizes[j]);
        }
      }
    }
  }
};

/// A term of many residuals without a landmark, the prior: one product instead of one for each pair
/// of its many blocks.
void accumulateDense(const Linearizer& lin, const Term& t, NormalEquations* eq) {
  const std::vector<int>& sizes = t.cost->parameter_block_sizes();
  std::vector<int> offset;
  int n = 0;
  for (std::size_t k = 0; k < sizes.size(); ++k) {
    offset.push_back(eq->offsetOf(t.blocks[k]));
    n += localSize(sizes[k]);
  }
  Eigen::MatrixXd J(lin.rows, n);
  int column = 0;
  for (std::size_t k = 0; k < sizes.size(); ++k) {
    J.middleCols(column, localSize(sizes[k])) = lin.J[k].leftCols(localSize(sizes[k]));
    column += localSize(sizes[k]);
  }
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(n, n);
  H.selfadjointView<Eigen::Upper>().rankUpdate(J.transpose());
  H.triangularView<Eigen::StrictlyLower>() = H.transpose();
  const Eigen::VectorXd b = J.transpose() * lin.r;
  int row = 0;
  for (std::size_t k = 0; k < sizes.size(); row += localSize(sizes[k++])) {
    const int at = offset[k], size = localSize(sizes[k]);
    if (at < 0) continue;
    eq->b.segment(at, size) += b.segment(row, size);
    column = 0;
    for (std::size_t m = 0; m < sizes.size(); column += localSize(sizes[m++])) {
      if (offset[m] < at) continue;
      eq->H.block(at, offset[m], size, localSize(sizes[m])) +=
          H.block(row, column, size, localSize(sizes[m]));
    }
  }
}

/// Only what lies on and above the diagonal of H is brought up to date.
void accumulate(const Linearizer& lin, const Term& t, NormalEquations* eq, LandmarkSystem* lm) {
  constexpr int kManyRows = 30;
  if (!t.landmark && lin.rows > kManyRows) return accumulateDense(lin, t, eq);
  const std::vector<int>& sizes = t.cost->parameter_block_sizes();
  const std::size_t n = sizes.size();
  lm->columns.resize(n);
  std::vector<int>& offset = lm->columns;
  for (std::size_t k = 0; k < n; ++k) offset[k] = eq->offsetOf(t.blocks[k]);
  for (std::size_t k = 0; k < n; ++k) {
    const int sk = localSize(sizes[k]);
    const auto Jk = lin.J[k].leftCols(sk);
    if (t.landmark && t.blocks[k] == t.landmark) {
      lm->H.noalias() += Jk.transpose().lazyProduct(Jk);
      lm->b.noalias() += Jk.transpose().lazyProduct(lin.r);
      for (std::size_t m = 0; m < n; ++m) {
        if (m == k || offset[m] < 0) continue;
        const int sm = localSize(sizes[m]);
        const int at = lm->slot(offset[m], sm);
        lm->coupling[at].topRows(sm).noalias() += lin.J[m].leftCols(sm).transpose().lazyProduct(Jk);
      }
      continue;
    }
    if (offset[k] < 0) continue;  // a block held constant
    eq->b.segment(offset[k], sk).noalias() += Jk.transpose().lazyProduct(lin.r);
    for (std::size_t m = 0; m < n; ++m) {
      if (offset[m] < offset[k]) continue;
      const int sm = localSize(sizes[m]);
      // Of few rows: a product that is prepared for large matrices would cost more than it does.
      eq->H.block(offset[k], offset[m], sk, sm).noalias() +=
          Jk.transpose().lazyProduct(lin.J[m].leftCols(sm));
    }
  }
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
  NormalEquations eq;
  int n = 0;
  for (BlockRef b : order) {
    b.offset = n;
    n += b.local();
    eq.blocks.push_back(b);
  }
  eq.H = Eigen::MatrixXd::Zero(n, n);
  eq.b = Eigen::VectorXd::Zero(n);
  Linearizer lin;
  LandmarkSystem lm;
  for (std::size_t i = 0; i < terms.size(); ++i) {
    lin.evaluate(terms[i]);
    accumulate(lin, terms[i], &eq, &lm);
    const bool last = i + 1 == terms.size() || terms[i + 1].landmark != terms[i].landmark;
    if (terms[i].landmark && last) {
      lm.eliminateFrom(&eq);
      lm.reset();
    }
  }
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

/// Directions of which nothing is known are left out.
void rootByEigenvalues(const Eigen::MatrixXd& A, const Eigen::VectorXd& s, const Eigen::VectorXd& b,
                       double relative, factors::LinearPrior* prior) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eig(A);
  std::vector<int> keep;
  for (int i = 0; i < eig.eigenvalues().size(); ++i) {
    if (eig.eigenvalues()[i] > relative) keep.push_back(i);
  }
  const auto rows = static_cast<int>(keep.size());
  prior->J.resize(rows, A.cols());
  prior->r0.resize(rows);
  for (int r = 0; r < rows; ++r) {
    const int k = keep[static_cast<std::size_t>(r)];
    const double root = std::sqrt(eig.eigenvalues()[k]);
    const auto v = eig.eigenvectors().col(k);
    prior->J.row(r) = root * (v.array() * s.array()).matrix().transpose();
    prior->r0[r] = v.dot(b) / root;
  }
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
    rootByEigenvalues(A, s, b, relative, &prior);
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
