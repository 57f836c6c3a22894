/// The part of Linearization that sights between a rig's cameras have.
#include <algorithm>

#include "add_square.h"
#include "linearization.h"

namespace vir::window {

Vec2 rigResidualOf(const TermLayout::Entry& e, const factors::SightGeometry& between,
                   factors::RigJacobians* J) {
  const Term& t = *e.term;
  const auto& f = static_cast<const factors::RigReprojectionFactor&>(*t.cost);
  const std::size_t first = f.sameFrame() ? 1 : 3;  // block of the calibration
  return factors::rigResidual(f.host(), f.sight(), between, Vec3(t.landmark),
                              factors::CameraVector(t.blocks[first + 1]),
                              factors::CameraVector(t.blocks[first + 3]), J);
}

template <typename Block>
void Linearization::addBlock(int row, int column, const Block& block) {
  constexpr int rows = Block::RowsAtCompileTime, columns = Block::ColsAtCompileTime;
  if (row <= column) {
    H_.block<rows, columns>(row, column) += block;
  } else {
    H_.block<columns, rows>(column, row) += block.transpose();
  }
}

void Linearization::flushRig() {
  using Sum = RigSum;
  for (int k = 0; k < Sum::kBlocks; ++k) {
    const int row = rig_.columns[k], rows = Sum::sizes[k], from = Sum::at[k];
    if (row < 0) continue;
    b_.segment(row, rows) += rig_.b.segment(from, rows);
    for (int m = k; m < Sum::kBlocks; ++m) {
      const int column = rig_.columns[m], columns = Sum::sizes[m];
      const auto block = rig_.H.block(from, Sum::at[m], rows, columns);
      if (row <= column) {
        H_.block(row, column, rows, columns) += block;
      } else {
        H_.block(column, row, columns, rows) += block.transpose();
      }
    }
  }
  std::fill(rig_.columns, rig_.columns + Sum::kBlocks, -1);
  rig_.H.setZero();
  rig_.b.setZero();
}

void Linearization::addRigSight(const TermLayout& layout, const TermLayout::Entry& e,
                                OwnBlock* own) {
  static_assert(factors::kCameraParameters == 8);
  const bool same = e.shape == TermShape::rig_pair;
  const int first = same ? 1 : 3;  // block of the calibration
  const auto pair = static_cast<std::size_t>(e.pair);
  const bool elsewhere = layout.pairs()[pair].linearizedElsewhere();
  factors::RigJacobians J;
  const Vec2 r = rigResidualOf(e, now_[pair], elsewhere ? nullptr : &J);
  if (elsewhere) rigResidualOf(e, linearized_[pair], &J);
  const double weight = addToSums(e, r.data(), 2, &sums_);
  const Vec2 residual = weight * r;
  // Within one frame the pose cancels: its rows stay 0 and have no column.
  Eigen::Matrix<double, RigSum::kSize, 2> common;
  common.topRows<6>() = weight * J.pose_i.transpose();
  if (same) common.topRows<6>().setZero();
  common.middleRows<6>(6) = weight * J.extrinsic_i.transpose();
  common.middleRows<8>(12) = weight * J.camera_i.transpose();
  common.middleRows<6>(20) = weight * J.extrinsic_j.transpose();
  common.bottomRows<8>() = weight * J.camera_j.transpose();
  const Eigen::Matrix<double, 3, 2> Jl = weight * J.landmark.transpose();

  int columns[RigSum::kBlocks] = {same ? -1 : layout.columnOf(e, 1)};
  for (int k = 0; k < 4; ++k) columns[1 + k] = layout.columnOf(e, first + k);
  if (!std::equal(columns, columns + RigSum::kBlocks, rig_.columns)) {
    flushRig();
    std::copy(columns, columns + RigSum::kBlocks, rig_.columns);
  }
  own->H += Jl.lazyProduct(Jl.transpose());
  own->b += Jl.lazyProduct(residual);
  addSquare<RigSum::kSize>(common, &rig_.H);
  rig_.b += common.lazyProduct(residual);
  coupling(layout, e, first).topRows<6>() += common.middleRows<6>(6).lazyProduct(Jl.transpose());
  coupling(layout, e, first + 1) += common.middleRows<8>(12).lazyProduct(Jl.transpose());
  coupling(layout, e, first + 2).topRows<6>() +=
      common.middleRows<6>(20).lazyProduct(Jl.transpose());
  coupling(layout, e, first + 3) += common.bottomRows<8>().lazyProduct(Jl.transpose());
  if (same) return;

  const Eigen::Matrix<double, 6, 2> Jj = weight * J.pose_j.transpose();
  const int j = layout.columnOf(e, 2);
  b_.segment<6>(j) += Jj.lazyProduct(residual);
  addBlock(j, j, Jj.lazyProduct(Jj.transpose()).eval());
  const Eigen::Matrix<double, 6, RigSum::kSize> across = Jj.lazyProduct(common.transpose());
  addBlock(j, columns[0], across.leftCols<6>().eval());
  addBlock(j, columns[1], across.middleCols<6>(6).eval());
  addBlock(j, columns[2], across.middleCols<8>(12).eval());
  addBlock(j, columns[3], across.middleCols<6>(20).eval());
  addBlock(j, columns[4], across.rightCols<8>().eval());
  coupling(layout, e, 1).topRows<6>() += common.topRows<6>().lazyProduct(Jl.transpose());
  coupling(layout, e, 2).topRows<6>() += Jj.lazyProduct(Jl.transpose());
}

}  // namespace vir::window
