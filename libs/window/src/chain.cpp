#include "chain.h"

namespace vir::window {
namespace {

/// A = L D L^T. Without pivots: A is positive definite, as every node is tied to the next.
void factorise(const Eigen::MatrixXd& H, EliminatedNode* out) {
  Vec5 d;
  for (int j = 0; j < kNodeSize; ++j) {
    double own = H(j, j);
    for (int k = 0; k < j; ++k) own -= out->L(j, k) * out->L(j, k) * d[k];
    d[j] = own;
    out->inverse_d[j] = own > 0 ? 1 / own : 0;
    for (int i = j + 1; i < kNodeSize; ++i) {
      double sum = H(i, j);
      for (int k = 0; k < j; ++k) sum -= out->L(i, k) * out->L(j, k) * d[k];
      out->L(i, j) = sum * out->inverse_d[j];
    }
  }
}

}  // namespace

Vec5 EliminatedNode::follow(const Eigen::VectorXd& next) const {
  Vec5 x = -inverse_d.cwiseProduct(z + y.transpose() * next);
  for (int j = kNodeSize - 1; j > 0; --j) {
    for (int i = 0; i < j; ++i) x[i] -= L(j, i) * x[j];
  }
  return x;
}

Frontal::Frontal(int band, int anchors) : band_(band) {
  const int n = kNodeSize * (band + 1) + kAnchorSize * anchors;
  H = Eigen::MatrixXd::Zero(n, n);
  b = Eigen::VectorXd::Zero(n);
  column_.resize(n);
}

void Frontal::eliminateFirst(EliminatedNode* out) {
  const int rest = static_cast<int>(H.rows()) - kNodeSize;
  factorise(H, out);
  // Columns of y are long and contiguous, so that all that follows are sums of few long vectors.
  out->y.resize(rest, kNodeSize);
  out->z = b.head<kNodeSize>();
  for (int k = 0; k < kNodeSize; ++k) {
    out->y.col(k) = H.col(k).tail(rest);
    for (int m = 0; m < k; ++m) {
      out->y.col(k).noalias() -= out->L(k, m) * out->y.col(m);
      out->z[k] -= out->L(k, m) * out->z[m];
    }
  }
  for (int j = 0; j < rest; ++j) {
    const Vec5 w = out->inverse_d.cwiseProduct(out->y.row(j).transpose());
    column_.head(j + 1).noalias() = out->y.topRows(j + 1).lazyProduct(w);
    H.col(kNodeSize + j).segment(kNodeSize, j + 1) -= column_.head(j + 1);
  }
  const Vec5 w = out->inverse_d.cwiseProduct(out->z);
  b.tail(rest).noalias() -= out->y.lazyProduct(w);
  moveOn();
}

/// The next nodes move up; behind them comes a fresh one, then the anchors where they were. Only
/// the upper half is right when this begins.
void Frontal::moveOn() {
  const int kept = kNodeSize * band_, n = static_cast<int>(H.rows());
  for (int j = 0; j < kept; ++j) {
    for (int i = 0; i <= j; ++i) H(i, j) = H(kNodeSize + i, kNodeSize + j);
    b[j] = b[kNodeSize + j];
  }
  for (int j = kept + kNodeSize; j < n; ++j) {
    for (int i = 0; i < kept; ++i) H(i, j) = H(kNodeSize + i, j);
    H.col(j).segment<kNodeSize>(kept).setZero();
  }
  H.block(0, kept, kept + kNodeSize, kNodeSize).setZero();
  b.segment<kNodeSize>(kept).setZero();
  H.triangularView<Eigen::StrictlyLower>() = H.transpose();
}

}  // namespace vir::window
