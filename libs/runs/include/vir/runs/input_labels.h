#pragma once
/// Recordings under labels of their own, matched to what an estimator asks for.
#include <map>
#include <string>
#include <vector>

#include "vir/roles/estimator.h"

namespace vir::runs {

struct InputLabels {
  /// A label of the recording, and which label of an input it stands for.
  std::map<std::string, std::string> as;
  std::vector<std::string> notes;  ///< what was taken for what, and what cannot be told
};

/// Looks into the rawlog, no further than it must. Of an input that is needed and whose label the
/// recording does not have, the only label with observations of its kind is taken; where there are
/// several, or where the input is not needed, nothing is taken and the labels are named. Throws
/// std::runtime_error if the rawlog cannot be opened.
InputLabels matchLabels(const std::vector<roles::EstimatorInput>& inputs,
                        const std::string& rawlog);

}  // namespace vir::runs
