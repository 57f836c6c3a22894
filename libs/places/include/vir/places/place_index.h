#pragma once
/// Which of the keyframes so far look like this one? Descriptors that agree in a few chosen bits
/// meet in a bucket of a table; several tables with other bits each, no vocabulary, nothing
/// trained.
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <vector>

#include "vir/core/options.h"
#include "vir/types/loop.h"

namespace vir::places {

struct PlaceIndexOptions {
  int max_keyframes = 20000;  ///< beyond, those go that are seen twice anyway
  int candidates = 5;         ///< at most, of one query
  double group_s = 3;         ///< keyframes within this long are one place
  int min_votes = 6;          ///< agreeing descriptors a candidate needs
  int max_distance_bits = 56;

  /// Throws std::invalid_argument for a value that is not allowed.
  void validate() const;
};
void describe(OptionVisitor& v, PlaceIndexOptions& o);

/// A keyframe that looks like the one asked for.
struct PlaceCandidate {
  std::uint64_t id = 0;
  double score = 0;  ///< agreeing descriptors, rare and near ones counting more
  int votes = 0;     ///< agreeing descriptors
};

/// The order of calls and the settings decide what comes out, nothing else. Queries may run in
/// several threads at a time, `add` alone.
class PlaceIndex {
 public:
  explicit PlaceIndex(const PlaceIndexOptions& options);
  ~PlaceIndex();
  PlaceIndex(PlaceIndex&&) noexcept;
  PlaceIndex& operator=(PlaceIndex&&) noexcept;

  /// Ids must rise from call to call. At most 1023 points count. Throws std::invalid_argument
  /// otherwise.
  void add(std::shared_ptr<const PlaceKeyframe> keyframe);
  using Allowed = std::function<bool(const PlaceKeyframe&)>;
  /// Best first, one per place, of keyframes with an id below `before` that `allowed` (none: all)
  /// does not rule out.
  std::vector<PlaceCandidate> query(
      const PlaceKeyframe& keyframe,
      std::uint64_t before = std::numeric_limits<std::uint64_t>::max(),
      const Allowed& allowed = {}) const;

  /// Null if it is not, or no longer, remembered.
  std::shared_ptr<const PlaceKeyframe> find(std::uint64_t id) const;
  /// The keyframe, then those of the same segment up to `reach` before and after it and within
  /// `group_s`, nearest first. Empty if it is not remembered.
  std::vector<std::shared_ptr<const PlaceKeyframe>> around(std::uint64_t id, int reach) const;
  /// In the order of their ids.
  std::vector<std::shared_ptr<const PlaceKeyframe>> keyframes() const;
  std::size_t size() const;
  /// Memory of the index and of the keyframes it holds, about.
  std::size_t bytes() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace vir::places
