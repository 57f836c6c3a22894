#pragma once
/// Ranges between anchors: a CObservationBeaconRanges labelled `ANCHOR:<id>` holds what that anchor
/// has measured to others.
#include <mrpt/obs/CObservationBeaconRanges.h>

#include <memory>
#include <vector>

#include "vir/types/anchor_range.h"

namespace vir::rawlog {

/// None for any other class or label.
std::vector<AnchorRange> anchorRangesOf(const mrpt::obs::CObservation& observation);
std::shared_ptr<mrpt::obs::CObservationBeaconRanges> toObservation(const AnchorRange& range);

}  // namespace vir::rawlog
