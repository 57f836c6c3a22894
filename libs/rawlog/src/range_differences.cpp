#include "vir/rawlog/range_differences.h"

#include <stdexcept>

#include "beacon_measurements.h"
#include "vir/rawlog/convert.h"
#include "vir/rawlog/labels.h"

namespace vir::rawlog {

std::vector<Range> rangeDifferencesOf(const mrpt::obs::CObservation& observation) {
  const auto reference = differenceReferenceOf(observation.sensorLabel);
  if (!reference) return {};
  std::vector<Range> out = beaconMeasurements(observation);
  for (Range& r : out) r.reference = *reference;
  return out;
}

std::shared_ptr<mrpt::obs::CObservationBeaconRanges> differenceObservation(
    const Range& difference) {
  if (!difference.reference) {
    throw std::invalid_argument("a difference of ranges without a reference anchor");
  }
  return toObservation(difference, differenceLabel(*difference.reference), kUnknownRadio);
}

}  // namespace vir::rawlog
