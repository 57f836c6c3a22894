#include "chain.h"

#include <algorithm>

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

/// `to` = `from` - y w, of the first n rows. By itself, since Eigen asks anew for each of these
/// short columns how it is best done; summed as it does, two by two, and the odd one out by halves.
void subtractSum(const double* __restrict from, const Eigen::Matrix<double, Eigen::Dynamic, 5>& y,
                 const Vec5& w, int n, double* __restrict to) {
  const auto stride = y.outerStride();
  const double* __restrict y0 = y.data(), * __restrict y1 = y0 + stride, * __restrict y2 = y1 + stride, * __restrict y3 = y2 + stride, * __restrict y4 = y3 + stride;
  const double w0 = w[0], w1 = w[1], w2 = w[2], w3 = w[3], w4 = w[4];
  const int even = n - n % 2, last = n - 1;
  for (int i = 0; i < even; ++i) {
    to[i] = from[i] - (y0[i] * w0 + y1[i] * w1 + y2[i] * w2 + y3[i] * w3 + y4[i] * w4);
  }
  if (even == n) return;
  to[last] = from[last] -
             ((y0[last] * w0 + y1[last] * w1) + (y2[last] * w2 + (y3[last] * w3 + y4[last] * w4)));
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
    out->y.col(k) = H.row(k).tail(rest);
    for (int m = 0; m < k; ++m) {
      out->y.col(k).noalias() -= out->L(k, m) * out->y.col(m);
      out->z[k] -= out->L(k, m) * out->z[m];
    }
  }
  // The next nodes move up in the same go; anchors stay where they are.
  const int moved = kNodeSize * band_;
  for (int j = 0; j < rest; ++j) {
    const Vec5 w = out->inverse_d.cwiseProduct(out->y.row(j).transpose());
    const double* from = H.col(kNodeSize + j).data() + kNodeSize;
    subtractSum(from, out->y, w, j + 1, column_.data());
    double* to = H.col(j < moved ? j : kNodeSize + j).data();
    const int nodes = std::min(j + 1, moved);
    std::copy_n(column_.data(), nodes, to);
    std::copy(column_.data() + nodes, column_.data() + j + 1, to + kNodeSize + nodes);
  }
  const Vec5 w = out->inverse_d.cwiseProduct(out->z);
  b.tail(rest).noalias() -= out->y.lazyProduct(w);
  makeRoom();
}

/// Behind the nodes that have moved up comes a fresh one.
void Frontal::makeRoom() {
  const int moved = kNodeSize * band_, rest = static_cast<int>(H.rows()) - moved - kNodeSize;
  H.topLeftCorner(moved, moved).triangularView<Eigen::StrictlyLower>() =
      H.topLeftCorner(moved, moved).transpose();
  H.block(0, moved, moved + kNodeSize, kNodeSize).setZero();
  H.block(moved, moved + kNodeSize, kNodeSize, rest).setZero();
  for (int i = 0; i < moved; ++i) b[i] = b[kNodeSize + i];
  b.segment<kNodeSize>(moved).setZero();
}

}  // namespace vir::window
