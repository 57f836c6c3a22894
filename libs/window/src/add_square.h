#pragma once
/// Internal: squares of small matrices whose size is known.
#include <Eigen/Core>

namespace vir::window {

/// On and above the diagonal of H += J J^T, a few columns at a time.
template <int size, int at = 0>
void addSquare(const Eigen::Matrix<double, size, 2>& J, Eigen::Matrix<double, size, size>* H) {
  constexpr int width = size % 4 == 0 ? 4 : 2;
  H->template block<at + width, width>(0, at).noalias() +=
      J.template topRows<at + width>().lazyProduct(J.template middleRows<width>(at).transpose());
  if constexpr (at + width < size) addSquare<size, at + width>(J, H);
}

}  // namespace vir::window
