#pragma once
/// Internal: the graph's keyframes and loops (mission_graph.cpp), its solution (graph_solve.cpp),
/// and the referee (referee.cpp).
#include <Eigen/SparseCholesky>
#include <memory>
#include <optional>
#include <vector>

#include "graph_edges.h"
#include "level_algebra.h"
#include "vir/mission/mission_graph.h"

namespace ceres {
class Problem;
}

namespace vir::mission {

struct GraphNode {
  PathNode path;
  double x[4] = {0, 0, 0, 0};  ///< p_M_B, yaw of W in M
  bool fixed = false;
  int stretch = 0;  ///< counts what the estimator followed without a gap; a map is one
  StepNoise step;   ///< from the node before
  std::optional<Odometry> odometry;  ///< see move()

  Vec3 position() const { return {x[0], x[1], x[2]}; }
  LevelTransform level() const { return {x[3], position()}; }
  void set(const LevelTransform& T);
  Pose T_M_B() const { return {Quat(rotZ(x[3])) * path.T_W_B.q, position()}; }
  /// T_M_W here.
  LevelTransform correction() const;
};

struct MissionGraph::Impl {
  explicit Impl(const GraphOptions& o) : options(o) {}

  int find(std::uint64_t id) const;  ///< -1: unknown
  LevelLoop level(const Loop& loop) const;
  LevelGuess guess(const Loop& loop) const;

  // The solution.
  /// `world` and all keyframes that anything says something of, in order: those that move.
  /// `of_path`: times the variances of what the estimator followed.
  std::vector<double*> build(ceres::Problem* problem, double of_path);
  /// Is the step to it the odometry's?
  bool followsOdometry(std::size_t node) const;
  /// How a keyframe lies to the one before, in the W of that one.
  LevelTransform stepOf(std::size_t node) const;
  /// Returns the sum of squared residuals; below 0 if there is no solution.
  double minimise(int iterations);
  /// Moves `scale` towards where path and loops are likeliest.
  void weigh();
  /// -2 log of their likelihood at `scale`, whatever variance both have in common; solves.
  double evidence();
  void decideOnLoops();
  /// Loops that were taken back and fit by now; true if there are any.
  bool takeIn();
  void graduate(double worst);
  /// The loop that all the rest contradicts most; true if it was taken back.
  bool takeBackWorst();
  /// What the rest says against a loop that is part of the solution: chi-square of four degrees of
  /// freedom (the residual in sigmas of its own, the loop's part in the solution taken off).
  double contradiction(const JudgedLoop& loop);
  /// Whitened by its own covariance; squared.
  double residualOf(const JudgedLoop& loop) const;
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>* factorised();
  std::unique_ptr<Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>> factorOf(double of_path);
  std::optional<LevelGuess> relative(int older, int newer);
  /// What the solution knows of the newest keyframe, into `newest`.
  void remember();
  /// By the way alone, from one keyframe to a later one.
  LevelGuess along(std::size_t from, std::size_t to) const;

  // The referee.
  LoopState judge(JudgedLoop* judged);
  /// Which stretches loops and nothing else have joined: for each the lowest of its group.
  std::vector<int> groups() const;
  bool tied(int older, int newer) const;
  bool agree(const Loop& one, const Loop& other);
  bool apart(const Loop& one, const Loop& other) const;
  /// Loops that wait and say the same as `loop`.
  std::vector<std::size_t> seconding(const Loop& loop);
  void accept(std::size_t loop);
  /// Moves what hangs together with the newer keyframe to where the loop has it.
  void join(const Loop& loop);

  GraphOptions options;
  std::vector<GraphNode> nodes;
  double world[4] = {0, 0, 0, 0};  ///< W in M, for what ties keyframes to it
  std::vector<JudgedLoop> loops;
  std::vector<double> weights;  ///< of the loops, 0 to 1
  double scale = 1;  ///< variances of the path against those of the loops, as both state them
  bool odometry_taken = false;  ///< see takeOdometry()
  std::size_t unsolved = 0;     ///< loops accepted since the last solution
  bool joined_anew = false;
  std::optional<LevelGuess> newest;  ///< of `newest_at` as seen from the oldest; none without loops
  std::size_t newest_at = 0;

  // Of the graph with its first `covered` keyframes; none when those or the loops have changed.
  std::unique_ptr<Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>> factor;
  std::size_t covered = 0;
  std::vector<int> column;  ///< of a node in it; -1: it does not move
};

}  // namespace vir::mission
