#include "vir/rawlog/anchor_ranges.h"

#include "vir/rawlog/convert.h"
#include "vir/rawlog/labels.h"

namespace vir::rawlog {

std::vector<AnchorRange> anchorRangesOf(const mrpt::obs::CObservation& observation) {
  std::vector<AnchorRange> out;
  const auto first = deployedAnchorOf(observation.sensorLabel);
  if (!first) return out;
  for (const Range& r : rangesOf(observation)) {
    out.push_back({r.t, *first, r.anchor, r.range_m, r.sigma_m});
  }
  return out;
}

std::shared_ptr<mrpt::obs::CObservationBeaconRanges> toObservation(const AnchorRange& range) {
  Range r;
  r.t = range.t;
  r.anchor = range.second;
  r.range_m = range.range_m;
  r.sigma_m = range.sigma_m;
  return toObservation(r, anchorLabel(range.first), kUnknownRadio);
}

}  // namespace vir::rawlog
