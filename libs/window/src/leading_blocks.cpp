#include "leading_blocks.h"

#include <Eigen/Cholesky>
#include <algorithm>

namespace vir::window {

/// Runs of columns that are not zero.
void LeadingBlocks::findTouched(const Eigen::MatrixXd& H, Block* block) {
  block->touched.clear();
  const int n = static_cast<int>(H.cols());
  for (int c = block->at + block->size; c < n; ++c) {
    if (H.col(c).segment(block->at, block->size).isZero(0)) continue;
    if (!block->touched.empty()) {
      Range& last = block->touched.back();
      if (last.from + last.size == c) {
        ++last.size;
        continue;
      }
    }
    block->touched.push_back({c, 1});
  }
}

bool LeadingBlocks::eliminate(const std::vector<int>& sizes, Eigen::MatrixXd* H,
                              Eigen::VectorXd* b) {
  blocks_.resize(std::max(blocks_.size(), sizes.size()));
  used_ = sizes.size();
  int at = 0;
  for (std::size_t k = 0; k < used_; ++k) {
    Block& block = blocks_[k];
    block.at = at;
    block.size = sizes[k];
    at += sizes[k];
    findTouched(*H, &block);
    int columns = 0;
    for (const Range& r : block.touched) columns += r.size;
    block.L = H->block(block.at, block.at, block.size, block.size).selfadjointView<Eigen::Upper>();
    const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> llt(block.L);  // in place
    if (llt.info() != Eigen::Success) return false;
    const auto L = block.L.triangularView<Eigen::Lower>();
    block.y.resize(block.size, columns);
    int c = 0;
    for (const Range& r : block.touched) {
      block.y.middleCols(c, r.size) = H->block(block.at, r.from, block.size, r.size);
      c += r.size;
    }
    block.z = b->segment(block.at, block.size);
    L.solveInPlace(block.y);
    L.solveInPlace(block.z);
    product_.setZero(columns, columns);
    product_.selfadjointView<Eigen::Upper>().rankUpdate(block.y.transpose());
    int i = 0;
    for (const Range& r : block.touched) {
      b->segment(r.from, r.size).noalias() -= block.y.middleCols(i, r.size).transpose() * block.z;
      H->block(r.from, r.from, r.size, r.size).triangularView<Eigen::Upper>() -=
          product_.block(i, i, r.size, r.size);
      int j = i + r.size;
      for (const Range* other = &r + 1; j < columns; j += other->size, ++other) {
        H->block(r.from, other->from, r.size, other->size) -=
            product_.block(i, j, r.size, other->size);
      }
      i += r.size;
    }
  }
  return true;
}

void LeadingBlocks::backSubstitute(Eigen::VectorXd* x) const {
  for (std::size_t k = used_; k-- > 0;) {
    const Block& block = blocks_[k];
    Eigen::VectorXd right = -block.z;
    int c = 0;
    for (const Range& r : block.touched) {
      right.noalias() -= block.y.middleCols(c, r.size) * x->segment(r.from, r.size);
      c += r.size;
    }
    block.L.triangularView<Eigen::Lower>().transpose().solveInPlace(right);
    x->segment(block.at, block.size) = right;
  }
}

}  // namespace vir::window
