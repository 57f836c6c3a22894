#include "joint_problem.h"

#include <ceres/loss_function.h>
#include <ceres/manifold.h>
#include <ceres/solver.h>

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "vir/factors/drift_edge_factor.h"
#include "vir/geometry/interpolation.h"
#include "vir/ranging/anchor_initialization.h"
#include "vir/types/interpolation.h"
#include "vir/types/unseen_motion.h"

namespace vir::team {
namespace {

using Vec5 = Eigen::Matrix<double, 5, 1>;

constexpr TimeNs kLongestGap = 1000000000;  // between two poses of a path
constexpr double kWeakPrior = 1e-6;   // information on every unknown: keeps the system solvable
constexpr double kExactScale = 1e-6;  // standard deviation of what is called right
constexpr double kStartSigma = 1e-3;  // of the first robot's first pose: the gauge
constexpr double kGate = 4;           // sigmas
constexpr double kLevel = 1e-3;       // [m]; a robot whose odometry rises by less moves in a plane
constexpr double kLevelSigma = 1e-3;  // [m], of its height

}  // namespace

JointProblem::JointProblem(const std::vector<JointRobot>& robots,
                           const std::vector<JointMutualRange>& mutual, const JointOptions& options)
    : options_(options) {
  for (const JointRobot& robot : robots) {
    addNodes(robot);
    if (!problem_.empty()) return;
  }
  constants_.resize(nodes_.size());
  holdStarts();
  addRanges(robots, mutual);
  startAnchors();
  for (const auto& list : nodes_) {
    first_column_.push_back(unknowns_);
    unknowns_ += 5 * list.size();
  }
  unknowns_ += 4 * constants_.size() + 3 * anchors_.size();
}

void JointProblem::addNodes(const JointRobot& robot) {
  std::vector<JointNode> list;
  double metres = 0, radians = 0, turn = 0, gap_s = 0, lowest = 1e300, highest = -1e300;
  const StampedPose* before = nullptr;
  for (const StampedPose& odometry : robot.odometry) {
    const auto estimate = vir::poseAt(robot.estimate, odometry.t, kLongestGap);
    if (before != nullptr) {
      metres += (odometry.T_W_B.p - before->T_W_B.p).norm();
      const double step = wrapAngle(yawOf(odometry.T_W_B.R()) - yawOf(before->T_W_B.R()));
      radians += std::abs(step);
      turn += step;
    }
    if (before != nullptr && odometry.t - before->t > kLongestGap) {
      gap_s += toSeconds(odometry.t - before->t);
    }
    before = &odometry;
    if (!estimate) continue;
    const bool due = list.empty() || gap_s > 0 || metres >= options_.node_distance_m ||
                     radians >= options_.node_turn_rad ||
                     toSeconds(odometry.t - list.back().t) >= options_.node_interval_s;
    if (!due) continue;
    JointNode node;
    node.t = odometry.t;
    node.T_O_B = odometry.T_W_B;
    node.metres = metres;
    node.radians = radians;
    node.turn_rad = turn;
    node.gap_s = gap_s;
    lowest = std::min(lowest, node.T_O_B.p.z());
    highest = std::max(highest, node.T_O_B.p.z());
    node.x.head<3>() = robot.T_C_W * estimate->p;
    node.x[3] = robot.T_C_W.yaw_rad + yawOf(estimate->R()) - yawOf(odometry.T_W_B.R());
    if (!list.empty()) node.x[3] = list.back().x[3] + wrapAngle(node.x[3] - list.back().x[3]);
    list.push_back(node);
    metres = radians = turn = gap_s = 0;
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
  // The nearer of the two along the way, if that is known.
  if (next != list.end() && next->gap_s == 0 &&
      (next->T_O_B.p - pose->p).norm() < (nearest->T_O_B.p - pose->p).norm()) {
    nearest = next;
  }
  NodePoint point;
  point.robot = index;
  point.node = static_cast<std::size_t>(nearest - list.begin());
  point.antenna = {pose->p - nearest->T_O_B.p, pose->q * p_B_U, pose->R().leftCols<2>()};
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
        anchors_[id] = {s.p_W.x(), s.p_W.y(), s.p_W.z(), 0};
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

std::size_t JointProblem::columnOfCentre(std::size_t robot) const {
  return unknowns_ - 3 * anchors_.size() - 4 * (constants_.size() - robot) + 2;
}

std::size_t JointProblem::columnOfAnchor(std::uint64_t id) const {
  const auto place = std::distance(anchors_.begin(), anchors_.find(id));
  return unknowns_ - 3 * anchors_.size() + 3 * static_cast<std::size_t>(place);
}

Vec3 JointProblem::position(const NodePoint& point) const {
  const JointNode& n = nodes_[point.robot][point.node];
  return n.x.head<3>() +
         rotZ(n.x[3]) * (std::exp(-n.x[4]) * point.antenna.motion_O + point.antenna.lever_O +
                         point.antenna.axes_O * centreOf(point.robot));
}

Pose JointProblem::poseAt(std::size_t robot, TimeNs t, const Pose& T_O_B) const {
  // Between two nodes both have a say, so that the path has no steps.
  const auto& list = nodes_[robot];
  const auto next = std::upper_bound(list.begin(), list.end(), t,
                                     [](TimeNs s, const JointNode& n) { return s < n.t; });
  const Vec3 centre_O = T_O_B.R().leftCols<2>() * centreOf(robot);
  const auto from = [&](const JointNode& n) {
    const Vec3 p =
        n.x.head<3>() + rotZ(n.x[3]) * (std::exp(-n.x[4]) * (T_O_B.p - n.T_O_B.p) + centre_O);
    return Pose(Quat(rotZ(n.x[3])) * T_O_B.q, p);
  };
  if (next == list.begin()) return from(list.front());
  const JointNode& before = *(next - 1);
  if (next == list.end()) return from(before);
  const double u = toSeconds(t - before.t) / toSeconds(next->t - before.t);
  return interpolate(from(before), from(*next), u);
}

Eigen::Vector2d JointProblem::centreOf(std::size_t robot) const {
  return {constants_[robot].centre[0], constants_[robot].centre[1]};
}

std::map<std::uint64_t, Vec3> JointProblem::anchors() const {
  std::map<std::uint64_t, Vec3> out;
  for (const auto& [id, x] : anchors_) out[id] = Vec3(x.data());
  return out;
}

double JointProblem::residual(const JointRange& r) const {
  const Vec3 other = r.second ? position(*r.second) : Vec3(anchors_.at(r.anchor).data());
  return (r.range_m - (position(r.first) - other).norm()) / r.sigma_m;
}

/// The scale is near 1; the first robot's start is where it is; and a robot that moves in a plane
/// keeps the height that the transform says: ranges know it by its square only.
void JointProblem::holdStarts() {
  const auto hold = [this](double* x, const Eigen::MatrixXd& J, const Eigen::VectorXd& x0) {
    factors::LinearPrior prior;
    prior.blocks.push_back({static_cast<int>(x0.size()), 0, {x0.data(), x0.data() + x0.size()}});
    prior.J = J;
    prior.r0 = Eigen::VectorXd::Zero(J.rows());
    held_.push_back({x, std::move(prior)});
  };
  const Eigen::Vector2d centre =
      Eigen::Vector2d::Constant(1 / std::hypot(options_.centre_sigma_m, kExactScale));
  const Eigen::Vector2d drift(1 / std::hypot(options_.heading_per_m, kExactScale),
                              1 / std::hypot(options_.heading_per_rad, kExactScale));
  for (std::size_t robot = 0; robot < nodes_.size(); ++robot) {
    auto& list = nodes_[robot];
    Vec5 weight = Vec5::Constant(std::sqrt(kWeakPrior)), x0 = Vec5::Zero();
    weight[4] = 1 / std::hypot(options_.scale_sigma, kExactScale);
    if (robot == 0) {
      weight.head<4>().setConstant(1 / kStartSigma);
      x0.head<4>() = list[0].x.head<4>();
    }
    hold(list[0].x.data(), weight.asDiagonal(), x0);
    hold(constants_[robot].drift.data(), drift.asDiagonal(), Eigen::Vector2d::Zero());
    hold(constants_[robot].centre.data(), centre.asDiagonal(), Eigen::Vector2d::Zero());
    if (!level_[robot]) continue;
    for (JointNode& node : list) {
      hold(node.x.data(), Vec5::Unit(2).transpose() / kLevelSigma, Vec5::Unit(2) * node.x[2]);
    }
  }
}

void JointProblem::fillPath(std::size_t robot, ceres::Problem* problem) {
  const JointOptions& o = options_;
  auto& list = nodes_[robot];
  for (std::size_t k = 1; k < list.size(); ++k) {
    JointNode &a = list[k - 1], &b = list[k];
    const double seconds = toSeconds(b.t - a.t);
    const double position = std::sqrt(o.noise.positionVariance(b.metres, b.radians, seconds) +
                                      1e-8 + unseenPositionVariance(b.gap_s));
    const double yaw = std::sqrt(o.noise.yawVariance(b.metres, b.radians, seconds) + 1e-10 +
                                 unseenYawVariance(b.gap_s));
    const double scale = o.scale_walk_per_sqrt_m * o.scale_walk_per_sqrt_m * b.metres + 1e-10;
    Eigen::Matrix4d W = Eigen::Matrix4d::Zero();
    W.diagonal() << 1 / position, 1 / position, 1 / (position * o.noise.usableVerticalShare()),
        1 / yaw;
    problem->AddResidualBlock(
        new factors::DriftEdgeFactor(b.T_O_B.p - a.T_O_B.p, W, std::sqrt(scale), b.metres,
                                     b.turn_rad),
        nullptr, std::vector<double*>{a.x.data(), b.x.data(), constants_[robot].drift.data()});
  }
}

void JointProblem::fill(ceres::Problem* problem, bool linear) {
  for (auto& list : nodes_) {
    for (JointNode& node : list) problem->AddParameterBlock(node.x.data(), 5);
  }
  for (Constants& c : constants_) {
    problem->AddParameterBlock(c.drift.data(), 2);
    problem->AddParameterBlock(c.centre.data(), 2);
  }
  for (auto& item : anchors_) {
    problem->AddParameterBlock(item.second.data(), 4,
                               new ceres::SubsetManifold(4, std::vector<int>{3}));
  }
  for (const Held& h : held_) {
    problem->AddResidualBlock(new factors::LinearPriorFactor(h.prior), nullptr, h.x);
  }
  for (std::size_t robot = 0; robot < nodes_.size(); ++robot) fillPath(robot, problem);
  for (const JointRange& r : ranges_) {
    factors::RangeTerm term{r.range_m, r.sigma_m, options_.robust};
    double worth = options_.range_worth;
    if (linear) {
      worth *= options_.robust.evaluate(residual(r)).influence();
      term.robust.huber_delta = term.robust.nlos_delta = 0;
    }
    double* const first = nodes_[r.first.robot][r.first.node].x.data();
    double* const centre = constants_[r.first.robot].centre.data();
    auto* const loss = new ceres::ScaledLoss(nullptr, worth, ceres::TAKE_OWNERSHIP);
    if (r.second) {
      double* const second = nodes_[r.second->robot][r.second->node].x.data();
      problem->AddResidualBlock(
          new factors::MutualRangeFactor(term, r.first.antenna, r.second->antenna), loss, first,
          second, centre, constants_[r.second->robot].centre.data());
    } else {
      problem->AddResidualBlock(new factors::CentredRangeFactor(term, r.first.antenna), loss, first,
                                anchors_.at(r.anchor).data(), centre);
    }
  }
}

void JointProblem::solve() {
  ceres::Problem problem;
  fill(&problem, false);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  // Ranges to an anchor at the robots' own height bend the valley: Levenberg-Marquardt creeps
  // there.
  options.trust_region_strategy_type = ceres::DOGLEG;
  options.dogleg_type = ceres::SUBSPACE_DOGLEG;
  // The same everywhere, however the machine's own sparse library adds up.
  options.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;
  options.max_num_iterations = options_.iterations;
  options.function_tolerance = options.gradient_tolerance = options.parameter_tolerance = 1e-12;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  cost_ = 2 * summary.final_cost;
  iterations_ = static_cast<int>(summary.iterations.size()) - 1;
}

std::pair<int, int> JointProblem::usedAndRejected() const {
  int used = 0, rejected = 0;
  for (const JointRange& r : ranges_) ++(std::abs(residual(r)) <= kGate ? used : rejected);
  return {used, rejected};
}

Eigen::MatrixXd JointProblem::covarianceTimes(const Eigen::MatrixXd& rhs) {
  ceres::Problem problem;
  fill(&problem, true);
  ceres::CRSMatrix jacobian;
  problem.Evaluate({}, nullptr, nullptr, nullptr, &jacobian);
  const Eigen::Map<const Eigen::SparseMatrix<double, Eigen::RowMajor>> J(
      jacobian.num_rows, jacobian.num_cols, static_cast<long>(jacobian.values.size()),
      jacobian.rows.data(), jacobian.cols.data(), jacobian.values.data());
  Eigen::SparseMatrix<double> H = J.transpose() * J;
  for (int i = 0; i < H.rows(); ++i) H.coeffRef(i, i) += kWeakPrior;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(H);
  return solver.solve(rhs);
}

}  // namespace vir::team
