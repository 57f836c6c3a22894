/// The long window's residuals and their elimination.
#include <Eigen/Dense>
#include <cmath>

#include "long_window_state.h"

namespace vir::window {
namespace {

using Row5 = Eigen::Matrix<double, 1, 5, Eigen::RowMajor>;
using Row4 = Eigen::Matrix<double, 1, 4, Eigen::RowMajor>;
using RowMat5 = Eigen::Matrix<double, 5, 5, Eigen::RowMajor>;
using RowMat35 = Eigen::Matrix<double, 3, 5, Eigen::RowMajor>;
using Vec1 = Eigen::Matrix<double, 1, 1>;

template <typename Matrix>
void zeroFrozen(bool yaw, bool scale, Matrix* J) {
  if (yaw) J->col(3).setZero();
  if (scale) J->col(4).setZero();
}

}  // namespace

int LongWindow::Impl::anchorIndex(std::uint64_t id) const {
  const auto it = anchors.find(id);
  return it == anchors.end() ? -1 : static_cast<int>(std::distance(anchors.begin(), it));
}

void LongWindow::Impl::addPrior(Frontal* f) const {
  std::vector<int> at;  // column in the frontal matrix of each block of the prior
  std::vector<int> size;
  std::vector<const double*> x;
  for (int k = 0; k < prior.nodes; ++k) {
    at.push_back(f->nodeOffset(k));
    size.push_back(kNodeSize);
    const std::size_t i = static_cast<std::size_t>(k);
    x.push_back(i < nodes.size() ? nodes[i].x : head.x);
  }
  for (std::uint64_t id : prior.anchors) {
    at.push_back(f->anchorOffset(anchorIndex(id)));
    size.push_back(kAnchorSize);
    x.push_back(anchors.at(id).x);
  }
  Eigen::VectorXd d(prior.lin.size());
  for (int k = 0, c = 0; k < static_cast<int>(at.size()); c += size[k++]) {
    for (int i = 0; i < size[k]; ++i) d[c + i] = x[k][i] - prior.lin[c + i];
  }
  const Eigen::VectorXd b = prior.b + prior.H * d;
  for (int k = 0, c = 0; k < static_cast<int>(at.size()); c += size[k++]) {
    f->b.segment(at[k], size[k]) += b.segment(c, size[k]);
    for (int m = 0, e = 0; m < static_cast<int>(at.size()); e += size[m++]) {
      f->H.block(at[k], at[m], size[k], size[m]) += prior.H.block(c, e, size[k], size[m]);
    }
  }
}

void LongWindow::Impl::addAnchorPriors(Frontal* f) const {
  int index = 0;
  for (const auto& [id, a] : anchors) {
    const int at = f->anchorOffset(index++);
    if (a.fixed) {
      f->H.block<4, 4>(at, at).diagonal().array() += 1;
      continue;
    }
    const Eigen::Map<const Eigen::Vector4d> x(a.x);
    f->H.block<4, 4>(at, at) += a.prior_information;
    f->b.segment<4>(at) += a.prior_information * (x - a.prior_mean);
  }
}

void LongWindow::Impl::addRanges(const LongNode& n, const std::vector<HeldRange>& ranges,
                                 Frontal* f) const {
  if (ranges.empty()) return;
  const factors::NodeFrame frame(n.x);
  for (const HeldRange& r : ranges) {
    if (r.reference) {
      addDifference(n, r, f);
      continue;
    }
    const int index = anchorIndex(r.anchor);
    if (index < 0) continue;
    const AnchorNode& a = anchors.at(r.anchor);
    Vec1 e;
    Row5 Jn;
    Row4 Ja;
    evaluate(r, frame, a, e.data(), Jn.data(), Ja.data());
    zeroFrozen(yawFrozen(), scaleFrozen(), &Jn);
    if (a.fixed) Ja.setZero();
    f->add<1, 5, 4>(e, Jn, 0, Ja, f->anchorOffset(index));
  }
}

void LongWindow::Impl::addDifference(const LongNode& n, const HeldRange& r, Frontal* f) const {
  const int first = anchorIndex(*r.reference), second = anchorIndex(r.anchor);
  if (first < 0 || second < 0 || first == second) return;
  const AnchorNode &reference = anchors.at(*r.reference), &a = anchors.at(r.anchor);
  Vec1 e;
  Row5 Jn;
  Row4 Jr, Ja;
  const double* blocks[3] = {n.x, reference.x, a.x};
  double* jacobians[3] = {Jn.data(), Jr.data(), Ja.data()};
  differenceOf(r, a, reference).Evaluate(blocks, e.data(), jacobians);
  zeroFrozen(yawFrozen(), scaleFrozen(), &Jn);
  if (reference.fixed) Jr.setZero();
  if (a.fixed) Ja.setZero();
  const int at_r = f->anchorOffset(first), at_a = f->anchorOffset(second);
  f->add<1, 5, 4>(e, Jn, 0, Jr, at_r);
  f->H.block<4, 4>(at_a, at_a) += Ja.transpose() * Ja;
  f->H.block<5, 4>(0, at_a) += Jn.transpose() * Ja;
  f->H.block<4, 4>(at_r, at_a) += Jr.transpose() * Ja;
  f->H.block<4, 4>(at_a, at_r) += Ja.transpose() * Jr;
  f->b.segment<4>(at_a) += Ja.transpose() * e;
}

void LongWindow::Impl::addNode(std::size_t k, Frontal* f) {
  const LongNode& n = nodes[k];
  addRanges(n, n.ranges, f);
  holdFrozen(f);
  if (position()) {
    for (std::size_t j = 0; j < n.links.size(); ++j) {
      const factors::PositionLinkFactor factor(n.links[j].z_W, n.links[j].gamma);
      Vec3 e;
      RowMat35 Ja, Jb;
      const double* blocks[2] = {n.x, node(k + 1 + j).x};
      double* jacobians[2] = {Ja.data(), Jb.data()};
      factor.Evaluate(blocks, e.data(), jacobians);
      f->add<3, 5, 5>(e, Ja, 0, Jb, f->nodeOffset(static_cast<int>(j) + 1));
    }
    return;
  }
  Vec5 e;
  RowMat5 Ja, Jb;
  factors::evaluateNodeEdge(n.motion_O, n.sqrt_information, n.sigma_log_scale, n.x, node(k + 1).x,
                            e.data(), Ja.data(), Jb.data());
  zeroFrozen(yawFrozen(), scaleFrozen(), &Ja);
  zeroFrozen(yawFrozen(), scaleFrozen(), &Jb);
  f->add<5, 5, 5>(e, Ja, 0, Jb, f->nodeOffset(1));
}

/// An entry that nothing may move stands alone in the equations.
void LongWindow::Impl::holdFrozen(Frontal* f) const {
  for (const int i : {3, 4}) {
    if (!(i == 3 ? yawFrozen() : scaleFrozen())) continue;
    f->H.row(i).setZero();
    f->H.col(i).setZero();
    f->H(i, i) = 1;
    f->b[i] = 0;
  }
}

/// What older nodes said about an anchor before it was fixed still couples it to the others.
void LongWindow::Impl::holdFixedAnchors(Frontal* f) const {
  int index = 0;
  for (const auto& [id, a] : anchors) {
    const int at = f->anchorOffset(index++);
    if (!a.fixed) continue;
    f->H.middleRows<kAnchorSize>(at).setZero();
    f->H.middleCols<kAnchorSize>(at).setZero();
    f->H.block<kAnchorSize, kAnchorSize>(at, at).setIdentity();
    f->b.segment<kAnchorSize>(at).setZero();
  }
}

void LongWindow::Impl::addClaim(Frontal* f) const {
  if (options.gauge_free_prior || claim.isZero()) return;
  Eigen::Vector4d d;
  d << head.position() - head.T_O_B.p, head.x[3];
  f->H.topLeftCorner<4, 4>() += claim;
  f->b.head<4>() += claim * d;
}

std::vector<double> LongWindow::Impl::headAndAnchors() const {
  std::vector<double> out(head.x, head.x + kNodeSize);
  for (const auto& [id, a] : anchors) out.insert(out.end(), a.x, a.x + kAnchorSize);
  return out;
}

const NormalEquations& LongWindow::eliminate() {
  Impl& s = *impl_;
  Frontal f(s.band(), static_cast<int>(s.anchors.size()));
  s.addAnchorPriors(&f);
  s.addSurvey(&f);
  s.addDistances(&f);
  s.addPrior(&f);
  s.eliminated.resize(s.nodes.size());
  for (std::size_t k = 0; k < s.nodes.size(); ++k) {
    s.addNode(k, &f);
    f.eliminateFirst(&s.eliminated[k]);
  }
  f.mirror();
  s.addClaim(&f);
  s.holdFrozen(&f);
  s.holdFixedAnchors(&f);

  const int tail = kAnchorSize * static_cast<int>(s.anchors.size());
  const int at = f.anchorOffset(0), n = kNodeSize + tail;
  NormalEquations& m = s.message;
  m.H.resize(n, n);
  m.b.resize(n);
  m.H.topLeftCorner<kNodeSize, kNodeSize>() = f.H.topLeftCorner<kNodeSize, kNodeSize>();
  m.H.topRightCorner(kNodeSize, tail) = f.H.block(0, at, kNodeSize, tail);
  m.H.bottomLeftCorner(tail, kNodeSize) = f.H.block(at, 0, tail, kNodeSize);
  m.H.bottomRightCorner(tail, tail) = f.H.block(at, at, tail, tail);
  m.b.head<kNodeSize>() = f.b.head<kNodeSize>();
  m.b.tail(tail) = f.b.segment(at, tail);
  m.blocks.clear();
  m.blocks.push_back({s.head.x, kNodeSize, 0, nullptr});
  int offset = kNodeSize;
  for (auto& [id, a] : s.anchors) {
    m.blocks.push_back({a.x, kAnchorSize, offset, nullptr});
    offset += kAnchorSize;
  }
  s.before = s.headAndAnchors();
  return m;
}

void LongWindow::backSubstitute() {
  Impl& s = *impl_;
  const int band = s.band(), tail = static_cast<int>(s.before.size()) - kNodeSize;
  const std::vector<double> now = s.headAndAnchors();
  Eigen::VectorXd next = Eigen::VectorXd::Zero(kNodeSize * band + tail);
  for (int i = 0; i < kNodeSize; ++i) next[i] = now[i] - s.before[i];
  for (int i = 0; i < tail; ++i) {
    next[kNodeSize * band + i] = now[kNodeSize + i] - s.before[kNodeSize + i];
  }
  for (std::size_t k = s.nodes.size(); k-- > 0;) {
    const EliminatedNode& e = s.eliminated[k];
    const Vec5 d = e.follow(next);
    for (int i = 0; i < kNodeSize; ++i) s.nodes[k].x[i] += d[i];
    for (int j = band - 1; j > 0; --j) {
      next.segment<kNodeSize>(kNodeSize * j) = next.segment<kNodeSize>(kNodeSize * (j - 1)).eval();
    }
    next.head<kNodeSize>() = d;
  }
  s.before = now;
}

/// The oldest node becomes part of the prior.
void LongWindow::Impl::marginaliseOldest() {
  Frontal f(band(), static_cast<int>(anchors.size()));
  addPrior(&f);
  addNode(0, &f);
  EliminatedNode gone;
  f.eliminateFirst(&gone);
  f.mirror();
  retired.push_back(std::move(nodes.front()));
  nodes.pop_front();

  prior.nodes = std::min<int>(band(), static_cast<int>(nodes.size()) + 1);
  prior.anchors.clear();
  const int n = kNodeSize * prior.nodes, tail = kAnchorSize * static_cast<int>(anchors.size());
  const int at = f.anchorOffset(0);
  prior.H.resize(n + tail, n + tail);
  prior.H << f.H.topLeftCorner(n, n), f.H.block(0, at, n, tail), f.H.block(at, 0, tail, n),
      f.H.block(at, at, tail, tail);
  prior.H = 0.5 * (prior.H + prior.H.transpose()).eval();
  prior.b.resize(n + tail);
  prior.b << f.b.head(n), f.b.segment(at, tail);
  prior.lin.resize(n + tail);
  for (int k = 0; k < prior.nodes; ++k) {
    const double* x = node(static_cast<std::size_t>(k)).x;
    for (int i = 0; i < kNodeSize; ++i) prior.lin[kNodeSize * k + i] = x[i];
  }
  int c = n;
  for (const auto& [id, a] : anchors) {
    prior.anchors.push_back(id);
    for (int i = 0; i < kAnchorSize; ++i) prior.lin[c++] = a.x[i];
  }
}

}  // namespace vir::window
