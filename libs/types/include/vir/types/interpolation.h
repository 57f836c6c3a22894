#pragma once
/// Between the stamps of a list: which neighbours, and the pose there.
#include <algorithm>
#include <optional>
#include <vector>

#include "vir/types/state.h"

namespace vir {
inline namespace types {

/// The two elements around a time, and how far it is from the first to the second (0..1). Where the
/// stamp is met exactly, both are the same element.
template <typename Stamped>
struct Neighbours {
  const Stamped* before = nullptr;
  const Stamped* next = nullptr;
  double s = 0;
};

/// `list`: elements with a stamp `t`, strictly increasing. Empty before the first, behind the last,
/// and between two that are farther apart than `longest_gap`.
template <typename Stamped>
std::optional<Neighbours<Stamped>> neighboursAt(const std::vector<Stamped>& list, TimeNs t,
                                                TimeNs longest_gap) {
  const auto next = std::lower_bound(list.begin(), list.end(), t,
                                     [](const Stamped& e, TimeNs stamp) { return e.t < stamp; });
  if (next == list.end()) return std::nullopt;
  if (next->t == t) return Neighbours<Stamped>{&*next, &*next, 0};
  if (next == list.begin()) return std::nullopt;
  const auto before = next - 1;
  if (next->t - before->t > longest_gap) return std::nullopt;
  return Neighbours<Stamped>{&*before, &*next,
                             toSeconds(t - before->t) / toSeconds(next->t - before->t)};
}

/// The interpolated pose; empty where neighboursAt() finds none.
std::optional<Pose> poseAt(const Trajectory& path, TimeNs t, TimeNs longest_gap);

/// Across any gap, and held before the first and behind the last. `path` must not be empty.
Pose heldPoseAt(const Trajectory& path, TimeNs t);

}  // namespace types
}  // namespace vir
