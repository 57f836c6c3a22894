#pragma once
#include <algorithm>
#include <cstddef>
#include <vector>

namespace vir {
inline namespace core {

/// The element that `share` (0..1) of the others do not exceed, rounded down; T() for none. Changes
/// the order of `values`.
template <typename T>
T quantileInPlace(std::vector<T>* values, double share) {
  if (values->empty()) return T();
  const auto at = values->begin() +
                  static_cast<std::ptrdiff_t>(share * static_cast<double>(values->size() - 1));
  std::nth_element(values->begin(), at, values->end());
  return *at;
}

/// Of an even number the upper one of the two in the middle; T() for none. Changes the order of
/// `values`.
template <typename T>
T medianInPlace(std::vector<T>* values) {
  if (values->empty()) return T();
  const auto middle = values->begin() + static_cast<std::ptrdiff_t>(values->size() / 2);
  std::nth_element(values->begin(), middle, values->end());
  return *middle;
}

template <typename T>
T median(std::vector<T> values) {
  return medianInPlace(&values);
}

}  // namespace core
}  // namespace vir
