#pragma once
/// Stretches of time in settings: pairs of numbers, seconds after the motion's begin.
#include <vector>

namespace vir::simulation {

/// Is `s` inside one of the stretches "from to from to ..."? Throws std::invalid_argument for an
/// odd number of values.
bool insideAny(const std::vector<double>& stretches, double s);

}  // namespace vir::simulation
