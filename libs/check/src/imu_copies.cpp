#include "vir/check/imu_copies.h"

#include <algorithm>

#include "text.h"

namespace vir::check {
namespace {

constexpr long kFewestRuns = 100;

}  // namespace

void ImuCopies::add(const ImuSample& s) {
  if (last_ && last_->acc == s.acc && last_->gyro == s.gyro) {
    ++length_;
    other_stamps_ = other_stamps_ || s.t != last_->t;
  } else {
    if (length_ > 0) ++runs_[std::min(length_, kLongest) - 1];
    length_ = 1;
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

}  // namespace vir::check
