#pragma once
/// Internal: blocks of a symmetric system that couple to few others, eliminated one by one.
#include <Eigen/Core>
#include <vector>

namespace vir::window {

/// Speeds and biases: each is tied to its neighbours in time, and to what the prior ties the oldest
/// to. Eliminated from the newest on, most of them touch few poses.
class LeadingBlocks {
 public:
  /// Takes the first blocks, of these sizes, out of H x = -b; both are changed in place, of H only
  /// what lies on and above the diagonal is read and written. False where H is not positive
  /// definite.
  bool eliminate(const std::vector<int>& sizes, Eigen::MatrixXd* H, Eigen::VectorXd* b);
  /// Fills in the first blocks of x, whose others are solved.
  void backSubstitute(Eigen::VectorXd* x) const;

 private:
  struct Range {
    int from = 0, size = 0;
  };
  /// L y = coupling and L z = gradient of one block, L being its factor.
  struct Block {
    int at = 0, size = 0;
    std::vector<Range> touched;
    Eigen::MatrixXd L, y;
    Eigen::VectorXd z;
  };
  static void findTouched(const Eigen::MatrixXd& H, Block* block);

  std::vector<Block> blocks_;
  std::size_t used_ = 0;
  Eigen::MatrixXd product_;
};

}  // namespace vir::window
