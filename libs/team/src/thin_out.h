#pragma once
#include <utility>
#include <vector>

namespace vir::team {

/// Beyond `most`, every second of the older half goes.
template <typename T>
void thinOut(std::size_t most, std::vector<T>* list) {
  if (list->size() <= most) return;
  std::vector<T> kept;
  kept.reserve(most + 1);
  for (std::size_t i = 0; i < list->size(); ++i) {
    if (i % 2 == 0 || i > list->size() / 2) kept.push_back(std::move((*list)[i]));
  }
  *list = std::move(kept);
}

}  // namespace vir::team
