#include "vir/team/joint_solution.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "joint_problem.h"
#include "vir/core/option_check.h"
#include "vir/core/options.h"

namespace vir::team {
namespace {

using Mat3x4 = Eigen::Matrix<double, 3, 4>;

Mat3x4 pointJacobian(const Vec3& rotated_p) {
  Mat3x4 J;
  J.col(0) = Vec3(-rotated_p.y(), rotated_p.x(), 0);
  J.rightCols<3>().setIdentity();
  return J;
}

/// Yaw and offset that lay `from` onto `to` (least squares, closed form).
WorldTransform aligned(const std::vector<Vec3>& from, const std::vector<Vec3>& to) {
  Vec3 mean_from = Vec3::Zero(), mean_to = Vec3::Zero();
  const auto n = static_cast<double>(from.size());
  for (std::size_t i = 0; i < from.size(); ++i) {
    mean_from += from[i] / n;
    mean_to += to[i] / n;
  }
  double sine = 0, cosine = 0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const Vec3 a = from[i] - mean_from, b = to[i] - mean_to;
    cosine += a.x() * b.x() + a.y() * b.y();
    sine += a.x() * b.y() - a.y() * b.x();
  }
  const double yaw = std::atan2(sine, cosine);
  return {yaw, mean_to - rotZ(yaw) * mean_from};
}

/// What lays a robot's own estimate onto its part of the solution, and how that depends on the
/// unknowns: the nodes' errors, and that of the centre, pass through the same least squares.
WorldTransform ownWorld(const JointProblem& problem, const JointRobot& robot, std::size_t index,
                        Eigen::MatrixXd* rows) {
  const std::vector<JointNode>& nodes = problem.nodes()[index];
  std::vector<Vec3> own, common;
  std::size_t at = 0;
  for (const JointNode& node : nodes) {
    while (at + 1 < robot.estimate.size() && robot.estimate[at].t < node.t) ++at;
    own.push_back(robot.estimate[at].T_W_B.p);
    common.push_back(problem.poseAt(index, node.t, node.T_O_B).p);
  }
  const WorldTransform T = aligned(own, common);
  const auto centre = static_cast<long>(problem.columnOfCentre(index));
  Eigen::Matrix4d N = Eigen::Matrix4d::Zero();
  *rows = Eigen::MatrixXd::Zero(static_cast<long>(problem.unknowns()), 4);
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    const Mat3x4 J = pointJacobian(rotZ(T.yaw_rad) * own[k]);
    N += J.transpose() * J;
    const auto column = static_cast<long>(problem.columnOf(index, k));
    const Vec3 offset = common[k] - nodes[k].x.head<3>();
    rows->middleRows<3>(column) = J;
    rows->row(column + 3) = Vec3(-offset.y(), offset.x(), 0).transpose() * J;
    rows->middleRows<2>(centre) +=
        (rotZ(nodes[k].x[3]) * nodes[k].T_O_B.R().leftCols<2>()).transpose() * J;
  }
  *rows *= N.inverse();
  return T;
}

void fillCovariances(JointProblem* problem, const Eigen::MatrixXd& rows, JointSolution* out) {
  out->covariance = rows.transpose() * problem->covarianceTimes(rows);
  for (const auto& [id, p_C] : problem->anchors()) {
    Eigen::MatrixXd pick = Eigen::MatrixXd::Zero(static_cast<long>(problem->unknowns()), 3);
    pick.middleRows<3>(static_cast<long>(problem->columnOfAnchor(id))).setIdentity();
    JointAnchor anchor;
    anchor.p_C = p_C;
    anchor.covariance = pick.transpose() * problem->covarianceTimes(pick);
    out->anchors[id] = anchor;
  }
}

}  // namespace

OdometryNoise jointNoiseDefaults() {
  OdometryNoise o;
  o.sigma_per_sqrt_m = 0.01;
  o.sigma_per_sqrt_s = 0.002;
  o.yaw_per_sqrt_m = 0.005;
  o.yaw_per_sqrt_rad = 0.005;
  o.yaw_per_sqrt_s = 0.001;
  o.vertical_share = 0.1;
  return o;
}

void JointOptions::validate() const { checkBounds(*this); }

void describe(OptionVisitor& v, JointOptions& o) {
  v.section("Joint", "Recordings of several robots solved together");
  v.value("node_distance_m", o.node_distance_m, {0.01, 100.0}, "distance between nodes");
  v.value("node_turn_rad", o.node_turn_rad, {0.01, 10.0}, "turn between nodes");
  v.value("node_interval_s", o.node_interval_s, {0.05, 1e4}, "longest time between nodes");
  describe(v, o.noise);
  v.value("scale_sigma", o.scale_sigma, {0.0, 10.0},
          "standard deviation of the odometry's scale; 0: it is right");
  v.value("scale_walk_per_sqrt_m", o.scale_walk_per_sqrt_m, {0.0, 10.0},
          "random walk of the scale with the distance [1/sqrt(m)]");
  v.value("heading_per_m", o.heading_per_m, {0.0, 1.0},
          "standard deviation of the heading's constant error along the way [rad/m]; 0: none");
  v.value("heading_per_rad", o.heading_per_rad, {0.0, 1.0},
          "standard deviation of the heading's constant error in turns [rad/rad]; 0: none");
  v.value("centre_sigma_m", o.centre_sigma_m, {0.0, 10.0},
          "standard deviation of where the body turns, in x and y from its origin [m]; 0: there");
  v.value("range_worth", o.range_worth, {1e-4, 1.0},
          "worth of a range among many whose errors resemble one another");
  v.value("iterations", o.iterations, {1, 10000}, "of the solver, at most");
}

WorldTransform JointSolution::between(std::size_t to, std::size_t from) const {
  return T_C_W[to].inverse() * T_C_W[from];
}

Eigen::Matrix4d JointSolution::covarianceBetween(std::size_t to, std::size_t from) const {
  // x = (yaw_f - yaw_t, R_t^T (t_f - t_t)).
  const Mat3 Rt = rotZ(-T_C_W[to].yaw_rad);
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(4, covariance.rows());
  const auto f = static_cast<long>(4 * from), t = static_cast<long>(4 * to);
  J(0, f) = 1;
  J(0, t) -= 1;
  J.block<3, 3>(1, f + 1) = Rt;
  J.block<3, 3>(1, t + 1) -= Rt;
  const Vec3 apart = Rt * (T_C_W[from].t_m - T_C_W[to].t_m);
  J.block<3, 1>(1, t) += Vec3(apart.y(), -apart.x(), 0);
  return J * covariance * J.transpose();
}

JointSolution solveJointly(const std::vector<JointRobot>& robots,
                           const std::vector<JointMutualRange>& mutual,
                           const JointOptions& options) {
  options.validate();
  JointSolution out;
  if (robots.size() < 2) {
    out.problem = "fewer than two robots";
    return out;
  }
  JointProblem problem(robots, mutual, options);
  if (!problem.problem().empty()) {
    out.problem = problem.problem();
    return out;
  }
  problem.solve();
  out.solved = true;
  out.heights_held = problem.heightsHeld();
  out.cost = problem.cost();
  out.iterations = problem.iterations();
  std::tie(out.ranges_used, out.ranges_rejected) = problem.usedAndRejected();
  Eigen::MatrixXd rows(static_cast<long>(problem.unknowns()), static_cast<long>(4 * robots.size()));
  for (std::size_t i = 0; i < robots.size(); ++i) {
    Eigen::MatrixXd own;
    out.T_C_W.push_back(ownWorld(problem, robots[i], i, &own));
    rows.middleCols(static_cast<long>(4 * i), 4) = own;
    std::vector<StampedPose> trajectory;
    for (const StampedPose& p : robots[i].odometry) {
      trajectory.push_back({p.t, problem.poseAt(i, p.t, p.T_W_B)});
    }
    out.trajectories.push_back(std::move(trajectory));
  }
  fillCovariances(&problem, rows, &out);
  return out;
}

}  // namespace vir::team
