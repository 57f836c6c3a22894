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

/// Of values in ascending order: what `share` (0..1) of them do not exceed, in a straight line
/// between the two nearest; at 0.5 the mean of the two in the middle of an even number. 0 for none.
inline double quantileOfSorted(const std::vector<double>& sorted, double share) {
  if (sorted.empty()) return 0;
  const double x = share * static_cast<double>(sorted.size() - 1);
  const auto i = static_cast<std::size_t>(x);
  const std::size_t j = std::min(i + 1, sorted.size() - 1);
  return sorted[i] + (x - static_cast<double>(i)) * (sorted[j] - sorted[i]);
}

}  // namespace core
}  // namespace vir
