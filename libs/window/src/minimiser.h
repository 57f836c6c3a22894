#pragma once
/// Internal: Levenberg-Marquardt on the terms of a window, landmarks eliminated.
#include <Eigen/Cholesky>
#include <vector>

#include "leading_blocks.h"
#include "linearization.h"

namespace vir::window {

/// What is minimised.
struct LeastSquares {
  /// Blocks that move, in this order; landmarks move too.
  std::vector<BlockRef> order;
  /// So many of them couple to few others: eliminated one by one.
  std::size_t leading = 0;
  const std::vector<Term>* terms = nullptr;
  /// Without landmarks, and of none of the leading blocks; may be nullptr.
  const std::vector<Term>* further = nullptr;
  /// Columns of `order` that do not move, although the terms have them.
  std::vector<int> held;
  /// Radius of the trust region after a step that was refused, at most; halved, one that began wide
  /// changes nothing of the next step.
  double refused_radius = 1e16;
};

/// How a minimisation ended.
struct Minimised {
  int iterations = 0;  ///< the start counts as one
  double initial_cost = 0;
  TermSums sums;  ///< where it ended; cost with the further terms, the rest without
  bool usable = false;
};

/// As Ceres has it: its damping, its tests for convergence and its growth of the trust region; a
/// test holds it against Ceres. Memory is kept from one problem to the next.
class Minimiser {
 public:
  /// The blocks hold what was found, or what they held before if that is not usable.
  Minimised minimise(const LeastSquares& problem, int iterations);
  /// What `terms` say, as of the last linearisation, of the blocks behind the leading ones: without
  /// further terms, nothing held. Empty if the last minimisation was not usable.
  const NormalEquations& information() const { return information_; }

 private:
  /// Of one set of terms.
  struct Part {
    TermLayout layout;
    Linearization now, next;
  };
  struct Point {
    TermSums sums;  ///< cost of both parts
    bool finite = false;
  };
  void setUp(const LeastSquares& problem);
  Point linearizeNext();
  Point evaluateNext();
  void swapLinearizations();
  void updateDamping();
  bool findStep(double radius);
  void buildReduced();
  double predictedDecrease() const;
  bool withoutGradient() const;
  void saveBlocks();
  void restoreBlocks();
  void applyStep();
  bool stepIsSmall() const;

  const LeastSquares* problem_ = nullptr;
  std::vector<int> leading_sizes_;
  int leading_columns_ = 0;
  Part terms_, further_;
  std::vector<double> before_;
  double norm_before_ = 0;

  Eigen::VectorXd scale_, diagonal_, damping_;
  LandmarkDamping landmark_scale_, landmark_diagonal_, landmark_damping_;
  bool scaled_ = false;

  LeadingBlocks leading_;
  Eigen::MatrixXd H_;
  Eigen::VectorXd b_;
  Eigen::LLT<Eigen::MatrixXd, Eigen::Upper> llt_;
  std::vector<Mat3> inverses_;
  Eigen::VectorXd step_;
  std::vector<Vec3> landmark_step_;
  NormalEquations information_;
};

}  // namespace vir::window
