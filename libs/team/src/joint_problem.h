#pragma once
/// The least-squares problem of solveJointly: nodes along each robot's odometry, anchors, ranges.
#include <ceres/problem.h>

#include <Eigen/SparseCore>
#include <array>
#include <deque>
#include <optional>

#include "vir/factors/linear_prior_factor.h"
#include "vir/factors/mutual_range_factor.h"
#include "vir/team/joint_solution.h"

namespace vir::team {

/// A node of the odometry as vir/factors/range_factor.h has it, W being the common world.
struct JointNode {
  TimeNs t = 0;
  Pose T_O_B;
  Eigen::Matrix<double, 5, 1> x = Eigen::Matrix<double, 5, 1>::Zero();  // p, yaw, log scale
  double metres = 0, radians = 0;  // of odometry from the node before
  double turn_rad = 0;             // by it, with sign
  double gap_s = 0;                // of it: without odometry
};

/// A point that moves with a node.
struct NodePoint {
  std::size_t robot = 0, node = 0;
  factors::AntennaAtNode antenna;
};

struct JointRange {
  NodePoint first;
  std::optional<NodePoint> second;  // else an anchor
  std::uint64_t anchor = 0;
  double range_m = 0, sigma_m = 0;
};

class JointProblem {
 public:
  JointProblem(const std::vector<JointRobot>& robots, const std::vector<JointMutualRange>& mutual,
               const JointOptions& options);

  /// Empty if it can be solved.
  const std::string& problem() const { return problem_; }
  void solve();

  double cost() const { return cost_; }
  bool heightsHeld() const {
    for (const bool level : level_) {
      if (level) return true;
    }
    return false;
  }
  int iterations() const { return iterations_; }
  const std::vector<std::vector<JointNode>>& nodes() const { return nodes_; }
  std::map<std::uint64_t, Vec3> anchors() const;
  /// Of an antenna.
  Vec3 position(const NodePoint& point) const;
  Pose poseAt(std::size_t robot, TimeNs t, const Pose& T_O_B) const;
  /// Ranges within four sigmas, and not.
  std::pair<int, int> usedAndRejected() const;
  /// Covariance times the columns of `rhs` (unknowns x n), at the solution.
  Eigen::MatrixXd covarianceTimes(const Eigen::MatrixXd& rhs);
  std::size_t unknowns() const { return unknowns_; }
  std::size_t columnOf(std::size_t robot, std::size_t node) const;
  /// Of the robot's centre [2].
  std::size_t columnOfCentre(std::size_t robot) const;
  std::size_t columnOfAnchor(std::uint64_t id) const;

 private:
  using Anchor = std::array<double, 4>;  // position, bias of the ranges: held at 0
  /// What is the same all along a robot's path.
  struct Constants {
    std::array<double, 2> drift{};   // of its heading: [rad/m], [rad/rad]
    std::array<double, 2> centre{};  // of the body's origin, from where the odometry turns [m]
  };

  void addNodes(const JointRobot& robot);
  void addRanges(const std::vector<JointRobot>& robots,
                 const std::vector<JointMutualRange>& mutual);
  void startAnchors();
  std::optional<NodePoint> pointAt(const JointRobot& robot, std::size_t index, TimeNs t,
                                   const Vec3& p_B_U) const;
  void holdStarts();
  /// `linear`: every range with the weight that it has now, for the covariance.
  void fill(ceres::Problem* problem, bool linear);
  void fillPath(std::size_t robot, ceres::Problem* problem);
  double residual(const JointRange& r) const;
  /// In x and y of the body [m].
  Eigen::Vector2d centreOf(std::size_t robot) const;

  const JointOptions options_;
  std::vector<std::vector<JointNode>> nodes_;
  std::vector<bool> level_;           // per robot: moves in a plane
  std::vector<Constants> constants_;  // per robot
  std::vector<JointRange> ranges_;
  std::map<std::uint64_t, Anchor> anchors_;
  std::string problem_;
  std::size_t unknowns_ = 0;
  std::vector<std::size_t> first_column_;  // per robot
  struct Held {
    double* x;
    factors::LinearPrior prior;
  };
  std::deque<Held> held_;  // factors keep references
  double cost_ = 0;
  int iterations_ = 0;
};

}  // namespace vir::team
