#pragma once
#include "vir/estimator/range_layer.h"

namespace vir {

/// Reads the file that [Ranges] bias_model names, if any. Throws std::runtime_error.
void loadBiasModel(estimator::RangeOptions* options);

}  // namespace vir
