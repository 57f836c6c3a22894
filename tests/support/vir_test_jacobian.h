#pragma once
/// Compares a cost function's Jacobians with central differences taken through the manifold of its
/// blocks, and checks that asking for Jacobians changes nothing else. Blocks of size 7 are poses.
#include <ceres/cost_function.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

#include "vir/factors/pose_manifold.h"

namespace vir_test {

using Blocks = std::vector<std::vector<double>>;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

inline std::vector<double> poseBlock(const vir::Pose& T) {
  std::vector<double> x(7);
  vir::factors::poseTo(T, x.data());
  return x;
}

/// Throws where `x` is not what `f` reads: a block too short would be read beyond its
/// end, and its Jacobian written there.
inline void requireBlocksOf(const ceres::CostFunction& f, const Blocks& x) {
  const std::vector<int>& sizes = f.parameter_block_sizes();
  bool same = sizes.size() == x.size();
  for (std::size_t k = 0; same && k < x.size(); ++k) {
    same = sizes[k] == static_cast<int>(x[k].size());
  }
  if (!same) throw std::invalid_argument("the blocks are not of the sizes that this factor takes");
}

inline std::vector<const double*> pointers(const Blocks& blocks) {
  std::vector<const double*> out;
  for (const std::vector<double>& b : blocks) out.push_back(b.data());
  return out;
}

inline Eigen::VectorXd residualOf(const ceres::CostFunction& f, const Blocks& x) {
  requireBlocksOf(f, x);
  Eigen::VectorXd r = Eigen::VectorXd::Constant(f.num_residuals(), NAN);
  EXPECT_TRUE(f.Evaluate(pointers(x).data(), r.data(), nullptr));
  return r;
}

/// Analytic Jacobians as the cost function writes them (ambient columns), NaN where nothing was
/// written; blocks in `without` are asked for with a null pointer.
inline std::vector<RowMajor> analyticJacobians(const ceres::CostFunction& f, const Blocks& x,
                                               Eigen::VectorXd* r, int without = -1) {
  requireBlocksOf(f, x);
  std::vector<RowMajor> J(x.size());
  std::vector<double*> p;
  for (std::size_t k = 0; k < x.size(); ++k) {
    J[k] = RowMajor::Constant(f.num_residuals(), static_cast<int>(x[k].size()), NAN);
    p.push_back(static_cast<int>(k) == without ? nullptr : J[k].data());
  }
  *r = Eigen::VectorXd::Constant(f.num_residuals(), NAN);
  EXPECT_TRUE(f.Evaluate(pointers(x).data(), r->data(), p.data()));
  return J;
}

/// Derivative in the local coordinates of block k, by Richardson-extrapolated central differences.
inline RowMajor numericJacobian(const ceres::CostFunction& f, const Blocks& x, std::size_t k,
                                double step) {
  const bool pose = x[k].size() == 7;
  const int columns = pose ? 6 : static_cast<int>(x[k].size());
  RowMajor J(f.num_residuals(), columns);
  const auto at = [&](int column, double h) {
    Blocks y = x;
    if (pose) {
      double delta[6] = {};
      delta[column] = h;
      vir::factors::PoseManifold().Plus(x[k].data(), delta, y[k].data());
    } else {
      y[k][static_cast<std::size_t>(column)] += h;
    }
    return residualOf(f, y);
  };
  for (int c = 0; c < columns; ++c) {
    const Eigen::VectorXd coarse = (at(c, 2 * step) - at(c, -2 * step)) / (4 * step);
    const Eigen::VectorXd fine = (at(c, step) - at(c, -step)) / (2 * step);
    J.col(c) = (4 * fine - coarse) / 3;
  }
  return J;
}

struct JacobianTolerance {
  double relative = 1e-6;  ///< of the largest entry of the block
  double absolute = 1e-7;
  double step = 1e-4;
};

/// Jacobians of `f` at `x` against differences of `numeric_of` (the same function unless its
/// Jacobians are meant to stand somewhere else) at `numeric_x`.
inline void expectJacobiansOf(const ceres::CostFunction& f, const Blocks& x,
                              const ceres::CostFunction& numeric_of, const Blocks& numeric_x,
                              const std::string& what, const JacobianTolerance& tolerance = {}) {
  Eigen::VectorXd r;
  const std::vector<RowMajor> J = analyticJacobians(f, x, &r);
  for (std::size_t k = 0; k < x.size(); ++k) {
    const RowMajor numeric = numericJacobian(numeric_of, numeric_x, k, tolerance.step);
    const RowMajor analytic = J[k].leftCols(numeric.cols());
    const double limit = tolerance.absolute + tolerance.relative * numeric.cwiseAbs().maxCoeff();
    const double worst = (analytic - numeric).cwiseAbs().maxCoeff();
    EXPECT_TRUE(worst <= limit) << what << ": Jacobian of block " << k << " is off by " << worst
                                << ", allowed " << limit << "\nanalytic\n"
                                << analytic << "\nnumeric\n"
                                << numeric << "\ndifference\n"
                                << analytic - numeric;
    if (x[k].size() == 7) {
      EXPECT_EQ(J[k].col(6).cwiseAbs().maxCoeff(), 0)
          << what << ": the seventh column of block " << k << " must be zero";
    }
  }
}

/// The residual is the same with and without Jacobians; every block may be left out.
inline void expectNullBlocksWork(const ceres::CostFunction& f, const Blocks& x,
                                 const std::string& what) {
  const Eigen::VectorXd plain = residualOf(f, x);
  Eigen::VectorXd r;
  const std::vector<RowMajor> all = analyticJacobians(f, x, &r);
  EXPECT_TRUE(plain.allFinite()) << what;
  EXPECT_EQ(plain, r) << what << ": asking for Jacobians changed the residual";
  for (std::size_t without = 0; without < x.size(); ++without) {
    const std::vector<RowMajor> some = analyticJacobians(f, x, &r, static_cast<int>(without));
    EXPECT_EQ(plain, r) << what << ": leaving out block " << without << " changed the residual";
    for (std::size_t k = 0; k < x.size(); ++k) {
      if (k == without) continue;
      EXPECT_TRUE(all[k] == some[k])
          << what << ": leaving out block " << without << " changed the Jacobian of block " << k;
    }
  }
}

/// All of the above for a cost function whose Jacobians stand at the current values.
inline void expectJacobians(const ceres::CostFunction& f, const Blocks& x, const std::string& what,
                            const JacobianTolerance& tolerance = {}) {
  expectNullBlocksWork(f, x, what);
  expectJacobiansOf(f, x, f, x, what, tolerance);
}

}  // namespace vir_test
