#include "bias_model_file.h"

#include <stdexcept>
#include <string>

#include "vir/core/text_file.h"

namespace vir {
namespace {

constexpr std::size_t kLargest = 4'000'000;  // [byte]

}  // namespace

void loadBiasModel(estimator::RangeOptions* options) {
  if (options->bias_model_file.empty()) return;
  std::string text;
  try {
    text = readTextFile(options->bias_model_file, kLargest);
  } catch (const std::runtime_error& e) {
    throw std::runtime_error("[Ranges] bias_model = " + options->bias_model_file +
                             ": cannot be read (" + e.what() +
                             "); give a file of `vir-slam calibrate uwb`");
  }
  options->bias_model = ranging::RangeBiasModel::fromText(text, options->bias_model_file);
}

}  // namespace vir
