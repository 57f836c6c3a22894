#include "vir/window/long_window.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "long_window_state.h"

namespace vir::window {
namespace {

/// W with W^T W = covariance^-1; a direction without covariance gets a floor.
Eigen::Matrix4d sqrtInformationOf(const Eigen::Matrix4d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> eig(0.5 *
                                                           (covariance + covariance.transpose()));
  const Eigen::Vector4d root =
      eig.eigenvalues().unaryExpr([](double l) { return 1.0 / std::sqrt(std::max(l, 1e-10)); });
  return root.asDiagonal() * eig.eigenvectors().transpose();
}

}  // namespace

void addHeldInWorld(const LongNode& node, const std::vector<HeldRange>& ranges,
                    const std::function<bool(const HeldRange&)>& wanted,
                    std::vector<HeldRange>* out) {
  std::optional<factors::NodeFrame> at;  // once for all of them
  for (const HeldRange& r : ranges) {
    if (!wanted(r)) continue;
    if (!at) at.emplace(node.x);
    out->push_back(r);
    out->back().motion = at->p_W_B + at->R_W_O * (at->shrink * r.motion + r.lever);
    out->back().lever.setZero();
  }
}

Pose LongNode::T_W_B() const { return {(Quat(rotZ(x[3])) * T_O_B.q).normalized(), position()}; }

LongWindow::LongWindow(const LongWindowOptions& options) : impl_(std::make_unique<Impl>(options)) {}
LongWindow::~LongWindow() = default;

bool LongWindow::empty() const { return !impl_->started; }

void LongWindow::clear() {
  const LongWindowOptions options = impl_->options;
  impl_ = std::make_unique<Impl>(options);
}

void LongWindow::start(TimeNs t, const Pose& T_O_B, const Pose& T_W_B, double sigma_m,
                       double sigma_rad) {
  Impl& s = *impl_;
  s.started = true;
  s.head = LongNode();
  s.head.t = t;
  s.head.T_O_B = T_O_B;
  for (int i = 0; i < 3; ++i) s.head.x[i] = T_W_B.p[i];
  const Mat3 R_W_O = (T_W_B.q * T_O_B.q.conjugate()).toRotationMatrix();
  s.head.x[3] = std::atan2(R_W_O(1, 0), R_W_O(0, 0));
  Vec5 information;
  const double scale = s.options.scale_sigma > 0 ? s.options.scale_sigma : 1.0;
  information << Vec3::Constant(1 / (sigma_m * sigma_m)), 1 / (sigma_rad * sigma_rad),
      1 / (scale * scale);
  s.prior.nodes = 1;
  s.prior.anchors.clear();
  s.prior.H = information.asDiagonal();
  s.prior.b = Vec5::Zero();
  s.prior.lin = Eigen::Map<const Vec5>(s.head.x);
}

void LongWindow::advance(TimeNs t, const Pose& T_O_B, std::vector<HeldRange> head_ranges,
                         const Eigen::Matrix4d& covariance, NodeTie tie) {
  Impl& s = *impl_;
  LongNode node = std::move(s.head);
  node.ranges = std::move(head_ranges);
  node.motion_O = T_O_B.p - node.T_O_B.p;
  const double k = s.options.edge_noise_scale;
  node.covariance = k * k * covariance;
  node.tie = tie;
  if (!s.options.conditional_edges && tie == NodeTie::followed) {
    Eigen::Vector4d fixed;
    fixed << Vec3::Constant(s.options.edge_sigma_m), s.options.edge_sigma_rad;
    node.covariance = fixed.cwiseAbs2().asDiagonal();
  }
  node.sqrt_information = sqrtInformationOf(node.covariance);
  node.sigma_log_scale =
      std::max(1e-5, s.options.scale_walk_per_sqrt_m * std::sqrt(node.motion_O.norm()));
  s.head = LongNode();
  s.head.t = t;
  s.head.T_O_B = T_O_B;
  const Vec3 p = node.position() + rotZ(node.x[3]) * (std::exp(-node.x[4]) * node.motion_O);
  for (int i = 0; i < 3; ++i) s.head.x[i] = p[i];
  s.head.x[3] = node.x[3];
  s.head.x[4] = node.x[4];
  s.nodes.push_back(std::move(node));
  if (s.position()) s.linkHead();
  while (static_cast<int>(s.nodes.size()) > s.limit()) s.marginaliseOldest();
}

void LongWindow::Impl::linkHead() {
  const std::size_t n = nodes.size();
  for (std::size_t back = 1; back <= 3 && back <= n; ++back) {
    LongNode& from = nodes[n - back];
    PositionLink link{head.T_O_B.p - from.T_O_B.p, options.gamma_s};
    const bool lost = from.tie == NodeTie::lost;
    // Across a stretch that nobody followed only its two ends are tied, and as loosely as is known.
    if (lost && back > 1) return;
    if (lost) link.gamma = 1 / std::sqrt(from.covariance.topLeftCorner<3, 3>().trace() / 3);
    from.links.push_back(link);
    if (lost) return;
  }
}

void LongWindow::headMoved(TimeNs t, const Pose& T_O_B) {
  Impl& s = *impl_;
  const Vec3 d_O = T_O_B.p - s.head.T_O_B.p;
  s.head.t = t;
  s.head.T_O_B = T_O_B;
  const Vec3 d_W = rotZ(s.head.x[3]) * (std::exp(-s.head.x[4]) * d_O);
  double total = 0;
  for (const LongNode& n : s.nodes) total += n.covariance.topLeftCorner<3, 3>().trace();
  double sum = 0;
  std::vector<double> part(s.nodes.size() + 1, 1.0);
  for (std::size_t k = 0; k < s.nodes.size(); ++k) {
    part[k] = total > 0 ? sum / total : 0;
    sum += s.nodes[k].covariance.topLeftCorner<3, 3>().trace();
  }
  for (int k = 0; k < s.prior.nodes; ++k) {
    s.prior.lin.segment<3>(kNodeSize * k) += part[static_cast<std::size_t>(k)] * d_W;
  }
  for (std::size_t k = 0; k <= s.nodes.size(); ++k) {
    LongNode& n = s.node(k);
    for (int i = 0; i < 3; ++i) n.x[i] += part[k] * d_W[i];
    if (k == s.nodes.size()) break;
    n.T_O_B.p += part[k] * d_O;
    n.motion_O += (part[k + 1] - part[k]) * d_O;
    for (std::size_t j = 0; j < n.links.size(); ++j) {
      n.links[j].z_W += (part[k + 1 + j] - part[k]) * d_O;
    }
  }
}

void LongWindow::setOdometryClaim(const Eigen::Matrix4d& covariance) {
  const Eigen::Matrix4d W = sqrtInformationOf(covariance);
  impl_->claim = W.transpose() * W;
}

Pose LongWindow::toWorld(const Pose& T_O_B) const {
  const LongNode& f = impl_->head;
  return {(Quat(rotZ(f.x[3])) * T_O_B.q).normalized(), pointToWorld(T_O_B.p)};
}

Vec3 LongWindow::pointToWorld(const Vec3& p_O) const {
  return impl_->head.position() + turnToWorld(p_O - impl_->head.T_O_B.p);
}

Vec3 LongWindow::turnToWorld(const Vec3& v_O) const {
  return rotZ(impl_->head.x[3]) * (std::exp(-impl_->head.x[4]) * v_O);
}

Vec3 LongWindow::antennaToWorld(const Vec3& p_O, const Vec3& lever_O) const {
  const LongNode& f = impl_->head;
  // As what the scale must not take off: one that is held at 1 changes no digit.
  return pointToWorld(p_O) + rotZ(f.x[3]) * ((1 - std::exp(-f.x[4])) * lever_O);
}

AnchorNode& LongWindow::addAnchor(std::uint64_t id, const Eigen::Vector4d& mean,
                                  const Eigen::Matrix4d& covariance) {
  AnchorNode& a = impl_->anchors[id];
  a.id = id;
  for (int i = 0; i < 4; ++i) a.x[i] = mean[i];
  a.prior_mean = mean;
  a.prior_information = covariance.inverse();
  return a;
}

void LongWindow::removeAnchor(std::uint64_t id) {
  Impl& s = *impl_;
  const auto at = std::find(s.prior.anchors.begin(), s.prior.anchors.end(), id);
  if (at != s.prior.anchors.end()) {
    const int c = kNodeSize * s.prior.nodes +
                  kAnchorSize * static_cast<int>(std::distance(s.prior.anchors.begin(), at));
    const int n = static_cast<int>(s.prior.lin.size());
    std::vector<int> keep;
    for (int i = 0; i < n; ++i) {
      if (i < c || i >= c + kAnchorSize) keep.push_back(i);
    }
    const Eigen::MatrixXd A = s.prior.H.block(c, c, 4, 4);
    const Eigen::MatrixXd inv =
        (A + 1e-12 * Eigen::Matrix4d::Identity()).completeOrthogonalDecomposition().pseudoInverse();
    const Eigen::MatrixXd W = s.prior.H.middleCols(c, 4) * inv;
    const Eigen::MatrixXd H = s.prior.H - W * s.prior.H.middleRows(c, 4);
    const Eigen::VectorXd b = s.prior.b - W * s.prior.b.segment(c, 4);
    LongPrior next;
    next.nodes = s.prior.nodes;
    next.anchors = s.prior.anchors;
    next.anchors.erase(next.anchors.begin() + std::distance(s.prior.anchors.begin(), at));
    const int m = static_cast<int>(keep.size());
    next.H.resize(m, m);
    next.b.resize(m);
    next.lin.resize(m);
    for (int i = 0; i < m; ++i) {
      next.b[i] = b[keep[i]];
      next.lin[i] = s.prior.lin[keep[i]];
      for (int j = 0; j < m; ++j) next.H(i, j) = H(keep[i], keep[j]);
    }
    s.prior = std::move(next);
  }
  s.anchors.erase(id);
}

AnchorNode* LongWindow::anchor(std::uint64_t id) {
  const auto it = impl_->anchors.find(id);
  return it == impl_->anchors.end() ? nullptr : &it->second;
}
const std::map<std::uint64_t, AnchorNode>& LongWindow::anchors() const { return impl_->anchors; }
double* LongWindow::headParameters() { return impl_->head.x; }
const LongNode& LongWindow::head() const { return impl_->head; }
const std::deque<LongNode>& LongWindow::nodes() const { return impl_->nodes; }
std::vector<LongNode> LongWindow::takeRetired() { return std::exchange(impl_->retired, {}); }
const LongWindowOptions& LongWindow::options() const { return impl_->options; }
const Eigen::MatrixXd& LongWindow::jointCovariance() const { return impl_->joint; }

bool LongWindow::yawFrozen() const { return impl_->yawFrozen(); }
bool LongWindow::scaleFrozen() const { return impl_->scaleFrozen(); }

std::vector<int> LongWindow::frozen() const {
  std::vector<int> out;
  if (impl_->yawFrozen()) out.push_back(3);
  if (impl_->scaleFrozen()) out.push_back(4);
  return out;
}

void LongWindow::setJointInformation(const NormalEquations& eq) {
  Impl& s = *impl_;
  s.joint = covarianceOf(eq);
  for (const int i : frozen()) {
    s.joint.row(i).setZero();
    s.joint.col(i).setZero();
  }
  s.joint_anchors.clear();
  int c = kNodeSize;
  for (const auto& [id, a] : s.anchors) {
    s.joint_anchors.push_back(id);
    if (a.fixed) {
      s.joint.middleRows(c, kAnchorSize).setZero();
      s.joint.middleCols(c, kAnchorSize).setZero();
    }
    c += kAnchorSize;
  }
}

int LongWindow::columnOf(std::uint64_t id) const {
  const auto& ids = impl_->joint_anchors;
  const auto it = std::find(ids.begin(), ids.end(), id);
  if (it == ids.end()) return -1;
  return kNodeSize + kAnchorSize * static_cast<int>(std::distance(ids.begin(), it));
}

factors::RangeTerm LongWindow::termOf(std::uint64_t anchor, double range_m, double sigma_m) const {
  const auto it = impl_->anchors.find(anchor);
  const double factor = it == impl_->anchors.end() ? 1 : it->second.variance_factor;
  return {range_m, sigma_m * std::sqrt(factor) / impl_->options.gamma_r, impl_->options.robust};
}

}  // namespace vir::window
