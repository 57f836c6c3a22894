#pragma once
/// Differences of ranges (TDoA): a CObservationBeaconRanges labelled `TDOA:<id>` holds the range to
/// each of its beacons less the range to that anchor [m], of either sign.
#include <mrpt/obs/CObservationBeaconRanges.h>

#include <memory>
#include <vector>

#include "vir/types/range.h"

namespace vir::rawlog {

/// None for any other class or label; rangesOf() gives none of these.
std::vector<Range> rangeDifferencesOf(const mrpt::obs::CObservation& observation);
/// `difference.reference` must be set; else throws std::invalid_argument.
std::shared_ptr<mrpt::obs::CObservationBeaconRanges> differenceObservation(const Range& difference);

}  // namespace vir::rawlog
