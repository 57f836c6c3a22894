/// The long window solved as a whole, for an odometry without short window.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "long_window_state.h"

namespace vir::window {

double LongWindow::Impl::cost(const std::vector<HeldRange>& head_ranges) {
  // The elimination's constant term is not kept: a plain sum over all residuals instead.
  double sum = 0;
  const auto ranges = [&](const LongNode& n, const std::vector<HeldRange>& list) {
    if (list.empty()) return;
    const factors::NodeFrame frame(n.x);
    for (const HeldRange& r : list) {
      const auto a = anchors.find(r.anchor);
      const auto reference = r.reference ? anchors.find(*r.reference) : anchors.end();
      if (a == anchors.end() || (r.reference && reference == anchors.end())) continue;
      double e = 0;
      if (r.reference) {
        const double* blocks[3] = {n.x, reference->second.x, a->second.x};
        differenceOf(r, a->second, reference->second).Evaluate(blocks, &e, nullptr);
      } else {
        evaluate(r, frame, a->second, &e, nullptr, nullptr);
      }
      sum += e * e;
    }
  };
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    const LongNode& n = nodes[k];
    ranges(n, n.ranges);
    if (position()) {
      for (std::size_t j = 0; j < n.links.size(); ++j) {
        const Vec3 to(node(k + 1 + j).x);
        sum += (n.links[j].gamma * (to - n.position() - n.links[j].z_W)).squaredNorm();
      }
      continue;
    }
    double e[5];
    factors::evaluateNodeEdge(n.motion_O, n.sqrt_information, n.sigma_log_scale, n.x, node(k + 1).x,
                              e, nullptr, nullptr);
    for (double v : e) sum += v * v;
  }
  ranges(head, head_ranges);
  for (const auto& [id, a] : anchors) {
    if (a.fixed) continue;
    const Eigen::Vector4d d = Eigen::Map<const Eigen::Vector4d>(a.x) - a.prior_mean;
    sum += d.dot(a.prior_information * d);
  }
  sum += costOfTies();
  Eigen::VectorXd d(prior.lin.size());
  int c = 0;
  for (int k = 0; k < prior.nodes; ++k) {
    const double* x = node(static_cast<std::size_t>(k)).x;
    for (int i = 0; i < kNodeSize; ++i, ++c) d[c] = x[i] - prior.lin[c];
  }
  for (std::uint64_t id : prior.anchors) {
    const double* x = anchors.at(id).x;
    for (int i = 0; i < kAnchorSize; ++i, ++c) d[c] = x[i] - prior.lin[c];
  }
  return sum + d.dot(prior.H * d) + 2 * prior.b.dot(d);
}

void LongWindow::Impl::takeStateOf(const Impl& other) {
  nodes = other.nodes;
  head = other.head;
  started = other.started;
  anchors = other.anchors;
  survey = other.survey;
  distances = other.distances;
  prior = other.prior;
  claim = other.claim;
}

void LongWindow::Impl::keepNodes() {
  kept.resize(nodes.size());
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    std::copy(std::begin(nodes[k].x), std::end(nodes[k].x), kept[k].begin());
  }
}

void LongWindow::Impl::restoreNodes() {
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    std::copy(kept[k].begin(), kept[k].end(), nodes[k].x);
  }
}

bool LongWindow::solve(int iterations, const std::vector<HeldRange>& head_ranges) {
  NormalEquations eq;
  const std::optional<double> cost = minimise(iterations, head_ranges, &eq);
  if (!cost) return false;
  setJointInformation(eq);
  return std::isfinite(*cost);
}

std::optional<double> LongWindow::minimise(int iterations,
                                           const std::vector<HeldRange>& head_ranges,
                                           NormalEquations* last) {
  Impl& s = *impl_;
  NormalEquations& eq = *last;
  double best = s.cost(head_ranges);
  for (int it = 0; it < iterations; ++it) {
    s.keepNodes();
    const LongNode head = s.head;
    const std::map<std::uint64_t, AnchorNode> anchors = s.anchors;
    eq = eliminate();
    Frontal f(s.band(), static_cast<int>(s.anchors.size()));
    s.addRanges(s.head, head_ranges, &f);
    const int tail = static_cast<int>(eq.H.rows()) - kNodeSize, at = f.anchorOffset(0);
    eq.H.topLeftCorner<5, 5>() += f.H.topLeftCorner<5, 5>();
    eq.H.topRightCorner(5, tail) += f.H.block(0, at, 5, tail);
    eq.H.bottomLeftCorner(tail, 5) += f.H.block(0, at, 5, tail).transpose();
    eq.H.bottomRightCorner(tail, tail) += f.H.block(at, at, tail, tail);
    eq.b.head<5>() += f.b.head<5>();
    eq.b.tail(tail) += f.b.segment(at, tail);
    const Eigen::VectorXd step = -eq.H.ldlt().solve(eq.b);
    if (!step.allFinite()) return std::nullopt;
    double factor = 1, value = 0;
    bool better = false;
    // Half steps until the cost falls: robust losses and a far start are not quadratic.
    for (int half = 0; half < 4 && !better; ++half, factor *= 0.5) {
      for (int i = 0; i < kNodeSize; ++i) s.head.x[i] = head.x[i] + factor * step[i];
      int c = kNodeSize;
      for (auto& [id, a] : s.anchors) {
        const double* x = anchors.at(id).x;
        for (int i = 0; i < kAnchorSize; ++i, ++c) a.x[i] = x[i] + factor * step[c];
      }
      s.before.assign(head.x, head.x + kNodeSize);
      for (const auto& [id, a] : anchors) {
        s.before.insert(s.before.end(), a.x, a.x + kAnchorSize);
      }
      s.restoreNodes();
      backSubstitute();
      value = s.cost(head_ranges);
      better = value <= best;
    }
    if (!better) {
      s.restoreNodes();
      s.head = head;
      s.anchors = anchors;
      break;
    }
    const bool done = best - value < 1e-6 * best;
    best = value;
    if (done) break;
  }
  return best;
}

double LongWindow::costWithAnchorAt(std::uint64_t id, const Vec3& p_W, int iterations,
                                    const std::vector<HeldRange>& head_ranges,
                                    Vec3* ends_at) const {
  LongWindow copy(impl_->options);
  copy.impl_->takeStateOf(*impl_);
  AnchorNode* a = copy.anchor(id);
  if (!a) return std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) a->x[i] = p_W[i];
  NormalEquations last;
  const std::optional<double> cost = copy.minimise(iterations, head_ranges, &last);
  if (!cost || !std::isfinite(*cost)) return std::numeric_limits<double>::infinity();
  *ends_at = copy.anchor(id)->position();
  return *cost;
}

}  // namespace vir::window
