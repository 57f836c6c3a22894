/// Ranges of a bag, and which antenna they are of.
#include <cmath>

#include "bag_recording.h"
#include "lever_arms.h"
#include "vir/core/time_bounds.h"
#include "vir/rawlog/labels.h"

namespace vir::bag {

using bags::MessageView;

void BagRecording::takeRanges(const MessageView& m, const Stream& s, TimeNs t, TimeNs received,
                              int index) {
  for (const ReadRange& r : readRanges(m, s.range)) {
    if (!std::isfinite(r.range_m) || std::abs(r.range_m) > 1e6) {
      log_->add("range_not_finite", whereOf(s, received), "the distance is no number");
      continue;
    }
    Range range;
    range.t = r.stamp.value_or(t);
    if (isStamp(range.t)) range.t += fromSeconds(options_.range_time_offset_s);
    range.anchor = static_cast<std::uint64_t>(anchors_.numberOfAny(r.anchor));
    range.range_m = r.range_m * options_.range_factor;
    range.sigma_m = r.sigma_m > 0 ? r.sigma_m : options_.range_sigma_m;
    if (!r.reference.empty()) {
      range.reference = static_cast<std::uint64_t>(anchors_.numberOfAny(r.reference));
      if (range.reference == range.anchor) {
        log_->add("range_implausible", whereOf(s, received),
                  "a difference of ranges to one and the same anchor");
        continue;
      }
    }
    if (r.place) places_.add(range.anchor, *r.place);
    const std::size_t antenna = antennaOf(s, index, r.tag);
    range.p_B_U = r.antenna.value_or(leverArm(options_.lever_arm_m, antenna));
    const bool own = antenna == s.antenna;
    const std::string label =
        own ? "" : rawlog::furtherLabel(rawlog::kRangeLabel, std::to_string(antenna));
    hold({range.t, index, range, label}, received, 0);
  }
}

std::size_t BagRecording::antennaOf(const Stream& s, int index, const std::string& tag) {
  if (tag.empty()) return s.antenna;
  const auto known = antennas_.find({index, tag});
  if (known != antennas_.end()) return known->second;
  bool first = true;
  for (const auto& [key, number] : antennas_) first = first && key.first != index;
  const std::size_t number = first ? s.antenna : next_antenna_++;
  antennas_[{index, tag}] = number;
  if (!first) {
    log_->note(s.topic + ": tag " + tag + " is labelled " +
               rawlog::furtherLabel(rawlog::kRangeLabel, std::to_string(number)) +
               "; its place in the body: the three numbers of lever_arm_m after those of the "
               "tags before it, where the messages tell none");
  }
  return number;
}

}  // namespace vir::bag
