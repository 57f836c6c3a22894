#include "vir/roles/range_labels.h"

#include <algorithm>

#include "vir/core/text.h"

namespace vir::roles {

bool isAmong(const std::string& label, const std::string& labels) {
  if (label == labels) return true;  // nearly always
  const auto words = wordsOf(labels);
  return std::find(words.begin(), words.end(), label) != words.end();
}

void addRangeInputs(const std::string& labels, std::vector<EstimatorInput>* inputs) {
  for (const std::string_view label : wordsOf(labels)) {
    inputs->push_back({InputKind::ranges, std::string(label), 0});
  }
}

}  // namespace vir::roles
