#pragma once
/// What marginalisation left: a linear residual around fixed values ("marginalization prior").
#include <ceres/cost_function.h>

#include <Eigen/Core>
#include <vector>

namespace vir::factors {

/// r = r0 + J (x - x0), x stacked over blocks; blocks of ambient size 7 are poses (6 local
/// coordinates), all others are vectors.
struct LinearPrior {
  struct Block {
    int ambient = 0;         ///< size of the parameter array
    int offset = 0;          ///< column of its first local coordinate in J
    std::vector<double> x0;  ///< linearisation point
    int local() const { return ambient == 7 ? 6 : ambient; }
  };
  std::vector<Block> blocks;
  Eigen::MatrixXd J;
  Eigen::VectorXd r0;
  int columns() const { return static_cast<int>(J.cols()); }
};

/// Keeps a reference to the prior: it must outlive the factor.
class LinearPriorFactor final : public ceres::CostFunction {
 public:
  explicit LinearPriorFactor(const LinearPrior& prior);
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override;
  /// The same as normal equations of all columns, which J^T J makes cheap: H and gradient b at x,
  /// and the squared norm of the residual.
  void linearize(double const* const* x, Eigen::MatrixXd* H, Eigen::VectorXd* b,
                 double* squared) const;
  const LinearPrior& prior() const { return prior_; }

 private:
  void difference(double const* const* x, Eigen::VectorXd* dx) const;

  const LinearPrior& prior_;
  mutable Eigen::MatrixXd JtJ_;  ///< once it is asked for
};

}  // namespace vir::factors
