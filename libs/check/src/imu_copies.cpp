#include "vir/check/imu_copies.h"

#include <algorithm>

#include "text.h"
#include "vir/core/time_bounds.h"

namespace vir::check {
namespace {

constexpr long kFewestRuns = 100;
constexpr TimeNs kStuck = 500'000'000;
/// Rest without noise, as of a simulation, is the same all the time; motion is not [rad/s].
constexpr double kTurns = 0.05;

}  // namespace

void ImuCopies::add(const ImuSample& s) {
  if (last_ && last_->acc == s.acc && last_->gyro == s.gyro) {
    ++length_;
    other_stamps_ = other_stamps_ || s.t != last_->t;
    const TimeNs lasts = timeBetween(run_from_, s.t);
    if (length_ >= kLongest && lasts > stuck_for_ && s.gyro.norm() > kTurns) {
      stuck_from_ = run_from_;
      stuck_for_ = lasts;
    }
  } else {
    if (length_ > 0) ++runs_[std::min(length_, kLongest) - 1];
    length_ = 1;
    run_from_ = s.t;
  }
  if (!last_) first_ = s.t;
  last_ = s;
}

std::optional<Finding> ImuCopies::finding(const std::string& label) const {
  long runs = 0, copied = 0;
  for (std::size_t i = 0; i < kLongest; ++i) {
    runs += runs_[i];
    // One that says nothing new for long is another matter, and rest without noise is none.
    if (i > 0 && i + 1 < kLongest) copied += runs_[i];
  }
  if (runs < kFewestRuns || 2 * copied < runs) return std::nullopt;
  const auto usual = std::max_element(runs_.begin() + 1, runs_.end() - 1) - runs_.begin() + 1;
  return Finding{Severity::doubtful,
                 "imu_copies",
                 label,
                 "each reading is there " +
                     (usual == 2 ? std::string("twice") : std::to_string(usual) + " times"),
                 num(100 * static_cast<double>(copied) / static_cast<double>(runs), 3) +
                     " % are followed by others with the same six numbers, at " +
                     (other_stamps_ ? "other stamps" : "the same stamp"),
                 other_stamps_
                     ? "ask the sensor no more often than it measures; if the stream was recorded "
                       "twice, leave the copies out"
                     : "leave the copies out; look for what writes them twice"};
}

std::optional<Finding> ImuCopies::stuck(const std::string& label) const {
  if (stuck_for_ < kStuck) return std::nullopt;
  return Finding{Severity::unusable,
                 "imu_stuck",
                 label,
                 "says the same six numbers for " + num(toSeconds(stuck_for_), 3) +
                     " s while it moves: it hangs",
                 "from " + num(toSeconds(timeBetween(first_, stuck_from_)), 4) +
                     " s after its first reading on",
                 "look for a driver that repeats its last reading when the sensor does not answer; "
                 "leave out what it says from there on"};
}

}  // namespace vir::check
