#pragma once
/// Readings that are there more than once.
#include <array>
#include <optional>
#include <string>

#include "vir/check/finding.h"
#include "vir/core/time.h"
#include "vir/types/imu_sample.h"

namespace vir::check {

/// Memory does not grow with the stream.
class ImuCopies {
 public:
  /// Finite readings, in the order in which they come.
  void add(const ImuSample& sample);
  std::optional<Finding> finding(const std::string& label) const;
  /// Whether it says the very same for half a second or more, of a motion or although what it says
  /// at other times has noise: as a sensor that hangs.
  std::optional<Finding> stuck(const std::string& label) const;

 private:
  static constexpr std::size_t kLongest = 20;
  std::optional<ImuSample> last_;
  std::size_t length_ = 0;             ///< of the run of readings with the same six numbers
  std::array<long, kLongest> runs_{};  ///< how many there were, by their length - 1
  bool other_stamps_ = false;          ///< of some copies than of what they are copies of
  TimeNs first_ = 0, run_from_ = 0;    ///< stamps of the first reading, and of that of the run
  struct Run {
    TimeNs from = 0, lasts = 0;
    std::size_t readings = 0;
  };
  bool noisy() const;
  Run longest_, longest_turning_;       ///< of the same numbers; and where these say that it turns
  long readings_ = 0, same_ = 0;        ///< in all, and as the one before
  long changes_ = 0, turned_back_ = 0;  ///< of the gyro's x, and against the change before
  double change_ = 0;
};

}  // namespace vir::check
