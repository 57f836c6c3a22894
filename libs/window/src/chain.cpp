#include "chain.h"

namespace vir::window {

Frontal::Frontal(int band, int anchors) : band_(band), anchors_(anchors) {
  const int n = kNodeSize * (band + 1) + kAnchorSize * anchors;
  H = Eigen::MatrixXd::Zero(n, n);
  b = Eigen::VectorXd::Zero(n);
}

void Frontal::eliminateFirst(EliminatedNode* out) {
  const int n = static_cast<int>(H.rows()), rest = n - kNodeSize;
  out->own.compute(H.topLeftCorner<kNodeSize, kNodeSize>());
  out->coupling = H.topRightCorner(kNodeSize, rest);
  out->b = b.head<kNodeSize>();
  const Eigen::Matrix<double, 5, Eigen::Dynamic> W = out->own.solve(out->coupling);
  Eigen::MatrixXd S = H.bottomRightCorner(rest, rest);
  S.noalias() -= out->coupling.transpose() * W;
  const Eigen::VectorXd s = b.tail(rest) - W.transpose() * out->b;

  // The next nodes move up; behind them comes a fresh one, then the anchors as before.
  const int kept = kNodeSize * band_, tail = kAnchorSize * anchors_;
  H.setZero();
  b.setZero();
  H.topLeftCorner(kept, kept) = S.topLeftCorner(kept, kept);
  H.topRightCorner(kept, tail) = S.topRightCorner(kept, tail);
  H.bottomLeftCorner(tail, kept) = S.bottomLeftCorner(tail, kept);
  H.bottomRightCorner(tail, tail) = S.bottomRightCorner(tail, tail);
  b.head(kept) = s.head(kept);
  b.tail(tail) = s.tail(tail);
}

}  // namespace vir::window
