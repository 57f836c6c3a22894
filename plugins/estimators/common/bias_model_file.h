#pragma once
#include "vir/estimator/range_layer.h"

namespace vir {

/// Reads the file that [Ranges] bias_model names, if any. Throws std::runtime_error.
void loadBiasModel(estimator::RangeOptions* options);

/// Reads the table that [Ranges] surveyed_anchors names, if any. Throws std::runtime_error.
void loadSurvey(estimator::RangeOptions* options);

/// `config` with what the files that it names hold. Throws std::runtime_error.
template <typename Config>
Config withFiles(Config config) {
  loadBiasModel(&config.ranges);
  loadSurvey(&config.ranges);
  return config;
}

}  // namespace vir
