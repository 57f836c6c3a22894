#pragma once
#include <mrpt/obs/CObservation.h>

#include <string>

namespace vir::rawlog {

/// Why an observation cannot be what a sensor said, in words that name no value: no stamp, or one
/// that no clock shows; a sensor or a camera placed by something that is no rotation or lies far
/// off the robot, a pose or an antenna that is no number or lies beyond the Earth. Empty for all
/// others, and for other classes.
std::string implausible(const mrpt::obs::CObservation& observation);

}  // namespace vir::rawlog
