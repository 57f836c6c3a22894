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
  /// Whether it says the very same of a motion for half a second or more, as a sensor that hangs.
  std::optional<Finding> stuck(const std::string& label) const;

 private:
  static constexpr std::size_t kLongest = 20;
  std::optional<ImuSample> last_;
  std::size_t length_ = 0;                 ///< of the run of readings with the same six numbers
  std::array<long, kLongest> runs_{};      ///< how many there were, by their length - 1
  bool other_stamps_ = false;              ///< of some copies than of what they are copies of
  TimeNs first_ = 0, run_from_ = 0;        ///< stamps of the first reading, and of that of the run
  TimeNs stuck_from_ = 0, stuck_for_ = 0;  ///< of the longest such run
};

}  // namespace vir::check
