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

 private:
  const LinearPrior& prior_;
};

}  // namespace vir::factors
