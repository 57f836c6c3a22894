#pragma once
/// Gaussian elimination on the normal equations of the window: landmarks first, then frames.
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <initializer_list>
#include <vector>

#include "vir/factors/linear_prior_factor.h"

namespace ceres {
class CostFunction;
}

namespace vir::window {

/// Parameter arrays of a term. Few as a rule: then they need no memory of their own, and a window
/// has thousands of terms.
class BlockList {
 public:
  BlockList() = default;
  BlockList(std::initializer_list<double*> blocks) {
    for (double* x : blocks) add(x);
  }
  BlockList(const std::vector<double*>& blocks) {
    for (double* x : blocks) add(x);
  }
  void add(double* x) {
    if (size_ < kFew) {
      few_[size_] = x;
    } else {
      if (size_ == kFew) many_.assign(few_.begin(), few_.end());
      many_.push_back(x);
    }
    ++size_;
  }
  std::size_t size() const { return size_; }
  double* const* data() const { return size_ > kFew ? many_.data() : few_.data(); }
  double* operator[](std::size_t k) const { return data()[k]; }
  double* const* begin() const { return data(); }
  double* const* end() const { return data() + size_; }

 private:
  static constexpr std::size_t kFew = 7;
  std::array<double*, kFew> few_{};
  std::vector<double*> many_;  ///< all of them, if there are more
  std::size_t size_ = 0;
};

/// One residual of the window with the parameter arrays it reads, in the cost function's order.
struct Term {
  const ceres::CostFunction* cost = nullptr;
  BlockList blocks;
  double robust = 0;           ///< scale of the robust loss on the whitened norm; 0 = none
  bool cauchy = false;         ///< Cauchy's loss, else Huber's
  double* landmark = nullptr;  ///< the landmark block among `blocks`, if any
};

/// A parameter block of the normal equations; ambient size 7 means a pose (6 local coordinates).
struct BlockRef {
  double* data = nullptr;
  int ambient = 0;
  int offset = 0;
  const double* lin = nullptr;  ///< first estimate, if the block's linearisation point is fixed
  int local() const { return ambient == 7 ? 6 : ambient; }
};

/// Cost 1/2 x^T H x + b^T x around the current values.
struct NormalEquations {
  std::vector<BlockRef> blocks;
  Eigen::MatrixXd H;
  Eigen::VectorXd b;
  /// Column of a block; -1 if it is not part of the equations.
  int offsetOf(const double* block) const;
};

/// Linearises the terms at the current values and eliminates every landmark (rank-safe: a landmark
/// whose depth is not observed keeps that direction out). Terms of one landmark must be adjacent.
/// `order` gives the blocks that remain, in the order of the result.
NormalEquations eliminateLandmarks(const std::vector<Term>& terms,
                                   const std::vector<BlockRef>& order);

/// Marginalises the first `count` blocks by a Schur complement with a rank-safe inverse.
NormalEquations marginalizeFirst(const NormalEquations& full, int count);

/// A parameter walks: its variance grows by `variance`, what is known of the others stays.
/// Nothing where nothing is known of it.
void addProcessNoise(int column, double variance, NormalEquations* eq);

/// Square-root form around each block's first estimate (`lin`), or its current value where it has
/// none yet. Directions whose information is below `relative` of
/// the scale of their own diagonal are left out (the gauge, unseen states).
factors::LinearPrior toPrior(const NormalEquations& eq, double relative = 1e-10);

/// Inverse of H with unobserved directions given no covariance (pseudo-inverse after scaling).
Eigen::MatrixXd covarianceOf(const NormalEquations& eq, double relative = 1e-12);

}  // namespace vir::window
