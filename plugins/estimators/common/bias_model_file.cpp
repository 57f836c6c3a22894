#include "bias_model_file.h"

#include <fstream>
#include <sstream>
#include <stdexcept>

namespace vir {

void loadBiasModel(estimator::RangeOptions* options) {
  if (options->bias_model_file.empty()) return;
  std::ifstream in(options->bias_model_file);
  if (!in) {
    throw std::runtime_error("[Ranges] bias_model = " + options->bias_model_file +
                             ": cannot be read; give a file of `vir-slam calibrate uwb`");
  }
  std::ostringstream text;
  text << in.rdbuf();
  options->bias_model = ranging::RangeBiasModel::fromText(text.str(), options->bias_model_file);
}

}  // namespace vir
