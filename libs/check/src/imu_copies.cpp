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
/// White noise goes to and fro in two of three readings, a motion in one of fifty; a brisk one with
/// noise in between.
constexpr long kFewestChanges = 50;
constexpr double kToAndFro = 0.1;
/// A sensor of coarse steps repeats itself at rest, with noise or without.
constexpr double kRare = 0.2;
/// So many of the same in a row.
constexpr std::size_t kFewestSame = 50;

}  // namespace

void ImuCopies::add(const ImuSample& s) {
  if (last_ && last_->acc == s.acc && last_->gyro == s.gyro) {
    ++length_;
    other_stamps_ = other_stamps_ || s.t != last_->t;
    ++same_;
    const TimeNs lasts = timeBetween(run_from_, s.t);
    if (lasts > longest_.lasts) longest_ = {run_from_, lasts, length_};
    if (length_ >= kLongest && lasts > longest_turning_.lasts && s.gyro.norm() > kTurns) {
      longest_turning_ = {run_from_, lasts, length_};
    }
  } else {
    if (length_ > 0) ++runs_[std::min(length_, kLongest) - 1];
    length_ = 1;
    run_from_ = s.t;
  }
  if (!last_) first_ = s.t;
  ++readings_;
  if (const double change = last_ ? s.gyro.x() - last_->gyro.x() : 0; change != 0) {
    ++changes_;
    turned_back_ += change * change_ < 0 ? 1 : 0;
    change_ = change;
  }
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

/// Where it does not repeat itself for long, its readings have noise and do not repeat themselves.
bool ImuCopies::noisy() const {
  const long others = readings_ - static_cast<long>(longest_.readings);
  const long same = same_ - static_cast<long>(longest_.readings) + 1;
  return changes_ >= kFewestChanges &&
         static_cast<double>(turned_back_) > kToAndFro * static_cast<double>(changes_) &&
         static_cast<double>(same) < kRare * static_cast<double>(others);
}

std::optional<Finding> ImuCopies::stuck(const std::string& label) const {
  const bool turns = longest_turning_.lasts >= kStuck && changes_ >= kFewestChanges;
  const bool hangs = longest_.lasts >= kStuck && longest_.readings >= kFewestSame && noisy();
  if (!turns && !hangs) return std::nullopt;
  const Run& run = hangs ? longest_ : longest_turning_;
  const TimeNs from = timeBetween(first_, run.from);
  return Finding{Severity::unusable,
                 "imu_stuck",
                 label,
                 "says the same six numbers for " + num(toSeconds(run.lasts), 3) + " s: it hangs",
                 "from " + num(toSeconds(from), 4) + " to " + num(toSeconds(from + run.lasts), 4) +
                     " s after its first reading; there may be shorter ones",
                 "look for a driver that repeats its last reading when the sensor does not answer; "
                 "leave out what it says there"};
}

}  // namespace vir::check
