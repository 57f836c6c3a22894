#pragma once
#include <cstddef>
#include <utility>
#include <vector>

namespace vir {
inline namespace core {

/// Keeps values of a stream that may go on for hours, evenly thinned out: all of them until there
/// are twice `shown`, from then on between that and `shown`.
template <typename T>
class ThinnedOut {
 public:
  /// `together`: so many in a row are kept or go together, for those who look at neighbours;
  /// divides `shown`.
  explicit ThinnedOut(std::size_t shown, std::size_t together = 1)
      : shown_(shown), together_(together) {}
  void add(T value) {
    if (seen_++ / together_ % stride_ == 0) kept_.push_back(std::move(value));
    if (kept_.size() < 2 * shown_) return;
    for (std::size_t i = together_; i < shown_; ++i) {
      kept_[i] = std::move(kept_[i + i / together_ * together_]);
    }
    kept_.resize(shown_);
    stride_ *= 2;
  }
  const std::vector<T>& values() const { return kept_; }

 private:
  std::size_t shown_, together_, seen_ = 0, stride_ = 1;
  std::vector<T> kept_;
};

}  // namespace core
}  // namespace vir
