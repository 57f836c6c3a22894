#include "bias_model_file.h"

#include <stdexcept>
#include <string>

#include "vir/core/text_file.h"
#include "vir/ranging/survey_table.h"

namespace vir {
namespace {

constexpr std::size_t kLargest = 4'000'000;  // [byte]

/// All of a file that a key of [Ranges] names; `what` it is to hold.
std::string textOf(const std::string& key, const std::string& path, const std::string& what) {
  try {
    return readTextFile(path, kLargest);
  } catch (const std::runtime_error& e) {
    throw std::runtime_error("[Ranges] " + key + " = " + path + ": cannot be read (" + e.what() +
                             "); give " + what);
  }
}

}  // namespace

void loadBiasModel(estimator::RangeOptions* options) {
  if (options->bias_model_file.empty()) return;
  const std::string text =
      textOf("bias_model", options->bias_model_file, "a file of `vir-slam calibrate uwb`");
  options->bias_model = ranging::RangeBiasModel::fromText(text, options->bias_model_file);
}

void loadSurvey(estimator::RangeOptions* options) {
  const std::string& path = options->surveyed_anchors;
  if (path.empty()) return;
  const std::string text = textOf("surveyed_anchors", path, "a table id,x,y,z,sigma");
  options->survey =
      ranging::surveyFromText(text, path, ranging::anchorNumbers(options->anchor_names));
}

}  // namespace vir
