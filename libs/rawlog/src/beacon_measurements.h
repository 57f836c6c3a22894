#pragma once
/// Internal: all that a CObservationBeaconRanges has measured, ranges or differences of them.
#include <mrpt/obs/CObservation.h>

#include <vector>

#include "vir/types/range.h"

namespace vir::rawlog {

std::vector<Range> beaconMeasurements(const mrpt::obs::CObservation& observation);

}  // namespace vir::rawlog
