#include "joint_problem.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "vir/geometry/interpolation.h"
#include "vir/ranging/anchor_initialization.h"
#include "vir/types/interpolation.h"

namespace vir::team {
namespace {

using Triplets = std::vector<Eigen::Triplet<double>>;
using Vec5 = Eigen::Matrix<double, 5, 1>;

constexpr TimeNs kLongestGap = 1000000000;  // between two poses of a path
constexpr double kWeakPrior = 1e-6;   // information on every unknown: keeps the system solvable
constexpr double kStartSigma = 1e-3;  // of the first robot's first pose: the gauge
constexpr double kGate = 4;           // sigmas
constexpr double kLevel = 1e-3;       // [m]; a robot whose odometry rises by less moves in a plane
constexpr double kLevelSigma = 1e-3;  // [m], of its height

Vec3 turned(const Vec3& v) { return {-v.y(), v.x(), 0}; }

/// Adds weight * [J_a J_b ..]^T [J_a J_b ..] and the gradient of one residual.
template <typename Blocks>
void addNormal(const Blocks& blocks, const Eigen::VectorXd& r, const Eigen::VectorXd& weight,
               Triplets* triplets, Eigen::VectorXd* g) {
  for (const auto& a : blocks) {
    const Eigen::MatrixXd WJ = weight.asDiagonal() * a.J;
    g->segment(static_cast<long>(a.column), a.J.cols()) += WJ.transpose() * r;
    for (const auto& b : blocks) {
      const Eigen::MatrixXd H = WJ.transpose() * b.J;
      for (int i = 0; i < H.rows(); ++i) {
        for (int j = 0; j < H.cols(); ++j) {
          if (H(i, j) == 0) continue;
          triplets->emplace_back(static_cast<int>(a.column) + i, static_cast<int>(b.column) + j,
                                 H(i, j));
        }
      }
    }
  }
}

}  // namespace

JointProblem::JointProblem(const std::vector<JointRobot>& robots,
                           const std::vector<JointMutualRange>& mutual, const JointOptions& options)
    : options_(options) {
  for (const JointRobot& robot : robots) {
    addNodes(robot);
    if (!problem_.empty()) return;
  }
  start_ = nodes_[0][0].x;
  addRanges(robots, mutual);
  startAnchors();
  for (const auto& list : nodes_) {
    first_column_.push_back(unknowns_);
    unknowns_ += 5 * list.size();
  }
  unknowns_ += 3 * anchors_.size();
}

void JointProblem::addNodes(const JointRobot& robot) {
  std::vector<JointNode> list;
  double metres = 0, radians = 0, lowest = 1e300, highest = -1e300;
  const StampedPose* before = nullptr;
  for (const StampedPose& odometry : robot.odometry) {
    const auto estimate = vir::poseAt(robot.estimate, odometry.t, kLongestGap);
    if (before != nullptr) {
      metres += (odometry.T_W_B.p - before->T_W_B.p).norm();
      radians += std::abs(wrapAngle(yawOf(odometry.T_W_B.R()) - yawOf(before->T_W_B.R())));
    }
    before = &odometry;
    if (!estimate) continue;
    const bool due = list.empty() || metres >= options_.node_distance_m ||
                     radians >= options_.node_turn_rad ||
                     toSeconds(odometry.t - list.back().t) >= options_.node_interval_s;
    if (!due) continue;
    JointNode node;
    node.t = odometry.t;
    node.p_O = odometry.T_W_B.p;
    node.metres = metres;
    node.radians = radians;
    lowest = std::min(lowest, node.p_O.z());
    highest = std::max(highest, node.p_O.z());
    node.x.head<3>() = robot.T_C_W * estimate->p;
    node.x[3] = robot.T_C_W.yaw_rad + yawOf(estimate->R()) - yawOf(odometry.T_W_B.R());
    if (!list.empty()) node.x[3] = list.back().x[3] + wrapAngle(node.x[3] - list.back().x[3]);
    node.start_height = node.x[2];
    list.push_back(node);
    metres = radians = 0;
  }
  level_.push_back(highest - lowest < kLevel);
  if (list.size() < 2) problem_ = "a robot has no odometry while it has estimated poses";
  nodes_.push_back(std::move(list));
}

std::optional<NodePoint> JointProblem::pointAt(const JointRobot& robot, std::size_t index, TimeNs t,
                                               const Vec3& p_B_U) const {
  const auto pose = vir::poseAt(robot.odometry, t, kLongestGap);
  const auto& list = nodes_[index];
  if (!pose || t < list.front().t || t > list.back().t + fromSeconds(5)) return std::nullopt;
  auto next = std::upper_bound(list.begin(), list.end(), t,
                               [](TimeNs s, const JointNode& n) { return s < n.t; });
  auto nearest = next - 1;
  // The nearer of the two along the way.
  if (next != list.end() && (next->p_O - pose->p).norm() < (nearest->p_O - pose->p).norm()) {
    nearest = next;
  }
  NodePoint point;
  point.robot = index;
  point.node = static_cast<std::size_t>(nearest - list.begin());
  point.motion_O = pose->p - nearest->p_O;
  point.lever_O = pose->q * p_B_U;
  return point;
}

void JointProblem::addRanges(const std::vector<JointRobot>& robots,
                             const std::vector<JointMutualRange>& mutual) {
  const auto good = [](double range, double sigma) {
    return std::isfinite(range) && range > 0 && std::isfinite(sigma) && sigma > 0;
  };
  for (std::size_t i = 0; i < robots.size(); ++i) {
    for (const Range& r : robots[i].anchor_ranges) {
      const auto point = pointAt(robots[i], i, r.t, r.p_B_U);
      if (!point || !good(r.range_m, r.sigma_m)) continue;
      ranges_.push_back({*point, std::nullopt, r.anchor, r.range_m, r.sigma_m});
    }
  }
  for (const JointMutualRange& r : mutual) {
    if (r.first >= robots.size() || r.second >= robots.size()) continue;
    const auto a = pointAt(robots[r.first], r.first, r.t, r.p_first_U);
    const auto b = pointAt(robots[r.second], r.second, r.t, r.p_second_U);
    if (!a || !b || !good(r.range_m, r.sigma_m)) continue;
    ranges_.push_back({*a, b, 0, r.range_m, r.sigma_m});
  }
}

/// From all robots' ranges together (what is a straight line for one need not be for all) and from
/// each one's alone (its own path may hang together better): whatever fits all best.
void JointProblem::startAnchors() {
  std::map<std::uint64_t, std::map<std::size_t, std::vector<ranging::AntennaRange>>> by_anchor;
  constexpr double kPathError = 0.2;  // [m], before it is corrected
  for (const JointRange& r : ranges_) {
    if (r.second) continue;
    by_anchor[r.anchor][r.first.robot].push_back(
        {position(r.first), r.range_m, std::hypot(r.sigma_m, kPathError)});
  }
  for (auto& [id, lists] : by_anchor) {
    std::vector<ranging::AntennaRange> all;
    for (const auto& item : lists) all.insert(all.end(), item.second.begin(), item.second.end());
    std::vector<std::vector<ranging::AntennaRange>> tries{all};
    if (lists.size() > 1) {
      for (const auto& item : lists) tries.push_back(item.second);
    }
    double best = std::numeric_limits<double>::infinity();
    for (const auto& list : tries) {
      ranging::AnchorInitOptions options;
      options.drift_ratio = 0;
      options.correlation = false;
      for (const ranging::AnchorSolution& s : ranging::initializeAnchor(list, options).solutions) {
        double cost = 0;
        for (const ranging::AntennaRange& r : all) {
          cost += options_.robust.loss((r.range_m - (r.p_W - s.p_W).norm()) / r.sigma_m);
        }
        if (!(cost < best) || !s.p_W.allFinite()) continue;
        best = cost;
        anchors_[id] = s.p_W;
      }
    }
  }
  ranges_.erase(std::remove_if(ranges_.begin(), ranges_.end(),
                               [&](const JointRange& r) {
                                 return !r.second && anchors_.count(r.anchor) == 0;
                               }),
                ranges_.end());
}

std::size_t JointProblem::columnOf(std::size_t robot, std::size_t node) const {
  return first_column_[robot] + 5 * node;
}

std::size_t JointProblem::columnOfAnchor(std::uint64_t id) const {
  const auto place = std::distance(anchors_.begin(), anchors_.find(id));
  return unknowns_ - 3 * anchors_.size() + 3 * static_cast<std::size_t>(place);
}

Vec3 JointProblem::position(const NodePoint& point) const {
  const JointNode& n = nodes_[point.robot][point.node];
  return n.x.head<3>() + rotZ(n.x[3]) * (std::exp(-n.x[4]) * point.motion_O + point.lever_O);
}

Pose JointProblem::poseAt(std::size_t robot, TimeNs t, const Pose& T_O_B) const {
  // Between two nodes both have a say, so that the path has no steps.
  const auto& list = nodes_[robot];
  const auto next = std::upper_bound(list.begin(), list.end(), t,
                                     [](TimeNs s, const JointNode& n) { return s < n.t; });
  const auto from = [&](const JointNode& n) {
    const Vec3 p = n.x.head<3>() + rotZ(n.x[3]) * (std::exp(-n.x[4]) * (T_O_B.p - n.p_O));
    return Pose(Quat(rotZ(n.x[3])) * T_O_B.q, p);
  };
  if (next == list.begin()) return from(list.front());
  const JointNode& before = *(next - 1);
  if (next == list.end()) return from(before);
  const double u = toSeconds(t - before.t) / toSeconds(next->t - before.t);
  return interpolate(from(before), from(*next), u);
}

double JointProblem::residual(const JointRange& r, Vec3* direction) const {
  const Vec3 other = r.second ? position(*r.second) : anchors_.at(r.anchor);
  const Vec3 v = position(r.first) - other;
  const double distance = v.norm();
  *direction = distance > 1e-9 ? Vec3(v / distance) : Vec3(Vec3::Zero());
  return (r.range_m - distance) / r.sigma_m;
}

double JointProblem::buildRanges(Triplets* triplets, Vector* g) const {
  double cost = 0;
  for (const JointRange& range : ranges_) {
    Vec3 u;
    const double r = residual(range, &u);
    cost += 2 * options_.range_worth * options_.robust.loss(r);
    if (triplets == nullptr) continue;
    const double weight = options_.range_worth * options_.robust.evaluate(r).influence();
    std::vector<Block> blocks;
    const auto add = [&](const NodePoint& point, double sign) {
      const JointNode& n = nodes_[point.robot][point.node];
      const Mat3 R = rotZ(n.x[3]);
      const Vec3 motion = R * (std::exp(-n.x[4]) * point.motion_O), lever = R * point.lever_O;
      Eigen::MatrixXd J(1, 5);
      J << sign * u.transpose(), sign * u.dot(turned(motion + lever)), -sign * u.dot(motion);
      blocks.push_back({columnOf(point.robot, point.node), J / range.sigma_m});
    };
    add(range.first, -1);
    if (range.second) {
      add(*range.second, 1);
    } else {
      blocks.push_back({columnOfAnchor(range.anchor), u.transpose() / range.sigma_m});
    }
    addNormal(blocks, Vector::Constant(1, r), Vector::Constant(1, weight), triplets, g);
  }
  return cost;
}

double JointProblem::buildEdges(Triplets* triplets, Vector* g) const {
  double cost = 0;
  const JointOptions& o = options_;
  const auto add = [&](const std::vector<Block>& blocks, const Vector& r, const Vector& weight) {
    cost += r.dot(weight.asDiagonal() * r);
    if (triplets != nullptr) addNormal(blocks, r, weight, triplets, g);
  };
  const Eigen::MatrixXd I5 = Eigen::MatrixXd::Identity(5, 5);
  for (std::size_t robot = 0; robot < nodes_.size(); ++robot) {
    const auto& list = nodes_[robot];
    // The scale is near 1; the first robot's start is where it is.
    Vector prior = Vector::Constant(5, kWeakPrior), off = Vector::Zero(5);
    prior[4] = 1 / (o.scale_sigma * o.scale_sigma + 1e-12);
    off[4] = list[0].x[4];
    if (robot == 0) {
      prior.head(4).setConstant(1 / (kStartSigma * kStartSigma));
      off.head(4) = (list[0].x - start_).head(4);
    }
    add({{columnOf(robot, 0), I5}}, off, prior);
    if (level_[robot]) {
      // Its height is what the transform says: ranges know it by its square only.
      for (std::size_t k = 0; k < list.size(); ++k) {
        Vector height = Vector::Zero(5), hold = Vector::Zero(5);
        height[2] = list[k].x[2] - list[k].start_height;
        hold[2] = 1 / (kLevelSigma * kLevelSigma);
        add({{columnOf(robot, k), I5}}, height, hold);
      }
    }
    for (std::size_t k = 1; k < list.size(); ++k) {
      const JointNode &a = list[k - 1], &b = list[k];
      const double seconds = toSeconds(b.t - a.t);
      const double position = o.noise.positionVariance(b.metres, b.radians, seconds) + 1e-8;
      const double yaw = o.noise.yawVariance(b.metres, b.radians, seconds) + 1e-10;
      const double scale = o.scale_walk_per_sqrt_m * o.scale_walk_per_sqrt_m * b.metres + 1e-10;
      const double share = o.noise.usableVerticalShare();
      const Mat3 Rt = rotZ(-a.x[3]);
      const Vec3 apart = Rt * (b.x - a.x).head<3>();
      const Vec3 moved = std::exp(-a.x[4]) * (b.p_O - a.p_O);
      Vector r(5), weight(5);
      r << apart - moved, b.x[3] - a.x[3], b.x[4] - a.x[4];
      weight << 1 / position, 1 / position, 1 / (position * share * share), 1 / yaw, 1 / scale;
      Eigen::MatrixXd Ja = Eigen::MatrixXd::Zero(5, 5), Jb = Eigen::MatrixXd::Zero(5, 5);
      Ja.topLeftCorner<3, 3>() = -Rt;
      Ja.block<3, 1>(0, 3) = -turned(apart);
      Ja.block<3, 1>(0, 4) = moved;
      Ja(3, 3) = Ja(4, 4) = -1;
      Jb.topLeftCorner<3, 3>() = Rt;
      Jb(3, 3) = Jb(4, 4) = 1;
      add({{columnOf(robot, k - 1), Ja}, {columnOf(robot, k), Jb}}, r, weight);
    }
  }
  return cost;
}

double JointProblem::build(Triplets* triplets, Vector* g) const {
  if (triplets != nullptr) {
    triplets->clear();
    *g = Vector::Zero(static_cast<long>(unknowns_));
    for (std::size_t i = 0; i < unknowns_; ++i) {
      triplets->emplace_back(static_cast<int>(i), static_cast<int>(i), kWeakPrior);
    }
  }
  return buildEdges(triplets, g) + buildRanges(triplets, g);
}

void JointProblem::step(const Vector& dx) {
  for (std::size_t robot = 0; robot < nodes_.size(); ++robot) {
    for (std::size_t k = 0; k < nodes_[robot].size(); ++k) {
      nodes_[robot][k].x += dx.segment<5>(static_cast<long>(columnOf(robot, k)));
    }
  }
  for (auto& [id, p] : anchors_) p += dx.segment<3>(static_cast<long>(columnOfAnchor(id)));
}

void JointProblem::solve() {
  Triplets triplets;
  Vector g;
  double lambda = 1e-6;
  cost_ = build(&triplets, &g);
  const auto n = static_cast<int>(unknowns_);
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver;
  for (iterations_ = 0; iterations_ < options_.iterations; ++iterations_) {
    Eigen::SparseMatrix<double> H(n, n);
    H.setFromTriplets(triplets.begin(), triplets.end());
    for (int i = 0; i < n; ++i) H.coeffRef(i, i) += lambda * (H.coeff(i, i) + 1);
    solver.compute(H);
    if (solver.info() != Eigen::Success) {
      lambda = std::max(10 * lambda, 1e-4);
      continue;
    }
    const Vector dx = -solver.solve(g);
    if (!dx.allFinite()) break;
    const auto nodes = nodes_;
    const auto anchors = anchors_;
    step(dx);
    const double then = build(nullptr, nullptr);
    if (!(then <= cost_)) {
      nodes_ = nodes;
      anchors_ = anchors;
      lambda = std::max(10 * lambda, 1e-6);
      if (lambda > 1e6) break;
      continue;
    }
    const bool done = cost_ - then < 1e-9 * (1 + cost_);
    lambda = std::max(0.1 * lambda, 1e-9);
    cost_ = build(&triplets, &g);
    if (done) break;
  }
}

std::pair<int, int> JointProblem::usedAndRejected() const {
  int used = 0, rejected = 0;
  for (const JointRange& r : ranges_) {
    Vec3 u;
    ++(std::abs(residual(r, &u)) <= kGate ? used : rejected);
  }
  return {used, rejected};
}

Eigen::MatrixXd JointProblem::covarianceTimes(const Eigen::MatrixXd& rhs) const {
  Triplets triplets;
  Vector g;
  build(&triplets, &g);
  const auto n = static_cast<int>(unknowns_);
  Eigen::SparseMatrix<double> H(n, n);
  H.setFromTriplets(triplets.begin(), triplets.end());
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(H);
  return solver.solve(rhs);
}

}  // namespace vir::team
