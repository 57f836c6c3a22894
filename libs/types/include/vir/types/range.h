#pragma once
/// Ranges, from the radio to the file.
#include <cstdint>
#include <optional>

#include "vir/core/time.h"
#include "vir/geometry/so3.h"

namespace vir {
inline namespace types {

/// A range to an anchor (or to another robot, whose id is then in `anchor`) as it comes from the
/// radio.
struct Range {
  TimeNs t = 0;  ///< its own time, on the clock of the IMU (or odometry)
  std::uint64_t anchor = 0;
  double range_m = 0;
  double sigma_m = 0;         ///< <= 0: not known, the setting is used
  Vec3 p_B_U = Vec3::Zero();  ///< antenna in the body [m]
  /// Set: a difference of ranges (TDoA); `range_m` is the range to `anchor` less that to this
  /// anchor, of either sign.
  std::optional<std::uint64_t> reference = std::nullopt;
};

/// What becomes of a range, and why it is not used.
enum class RangeDecision {
  accepted,
  collected,  ///< kept for an anchor that has no position yet
  too_long,   ///< against its prediction
  too_short,
  invalid,  ///< its prediction is no number
  not_finite,
  negative,
  zero,
  too_far,  ///< beyond what the radio can
  repeated,
  out_of_order,
  stuck,  ///< the same number for too long
  too_many_anchors,
  bad_id,
  too_late,          ///< the keyframes of its time are gone
  before_the_start,  ///< no pose to hang it on
};
/// As written in ranges.csv.
const char* name(RangeDecision decision);

/// One range with what was decided when it was processed (causal).
struct RangeRecord {
  TimeNs t = 0;
  std::uint64_t anchor = 0;
  double measured_m = 0;
  double predicted_m = 0;  ///< bias included; 0 if there is no prediction
  double residual_m = 0;   ///< measured - predicted; 0 if there is no prediction
  double sigma_m = 0;      ///< of the prediction and the range together; 0 if none
  double weight = 0;       ///< of the robust loss, 0..1
  RangeDecision decision = RangeDecision::collected;
  std::optional<std::uint64_t> reference = std::nullopt;  ///< as of Range
};

}  // namespace types
}  // namespace vir
