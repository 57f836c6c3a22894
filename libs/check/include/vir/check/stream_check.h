#pragma once
/// Stamps of the streams of a recording, alone and against each other.
#include <string>
#include <vector>

#include "vir/check/finding.h"
#include "vir/core/time.h"

namespace vir::check {

enum class StreamKind { images, imu, ranges, poses, other };

/// From here on it comes at another rate.
struct RateChange {
  TimeNs at = 0;
  double from_hz = 0, to_hz = 0;
};

struct StreamSummary {
  std::string label;
  StreamKind kind = StreamKind::other;
  long count = 0;
  TimeNs first = 0, last = 0;
  double rate_hz = 0;   ///< of the median period
  double jitter_s = 0;  ///< median distance of a period from the median period
  double longest_gap_s = 0;
  long out_of_order = 0, repeated = 0;
  std::vector<RateChange>
      rate_changes;  ///< the first ones, by 30 % or more; exact to some readings
};

/// Memory does not grow with the stream.
class StreamCheck {
 public:
  StreamCheck(std::string label, StreamKind kind);
  /// In the order in which they come.
  void add(TimeNs t);
  StreamSummary summary() const;

 private:
  void followRate(TimeNs t, TimeNs period);

  StreamSummary s_;
  TimeNs newest_ = 0;
  std::vector<TimeNs> periods_;  ///< the first ones
  std::vector<TimeNs> latest_;   ///< of the block that is being filled
  TimeNs block_start_ = 0, other_since_ = 0;
  TimeNs usual_ = 0, other_ = 0;  ///< median periods: as it is, and of a block that differs
};

/// Rates that cannot be (stamps in another unit), gaps, order, and streams that do not overlap.
/// `poses` streams are the ground truth or odometry; the first of `images` is the camera that a run
/// looks through.
std::vector<Finding> checkStreams(const std::vector<StreamSummary>& streams);

}  // namespace vir::check
