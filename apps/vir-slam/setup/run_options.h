#pragma once
#include <string>

#include "vir/core/options.h"

namespace vir::app {

/// What the program itself reads in [Estimator]; the estimator plugin declares the rest.
struct RunOptions {
  std::string driver = "auto";
  std::string rawlog;
  std::string calibration;  ///< file; empty: none
  double start_offset_s = 0;
  double duration_s = 0;
};

void describe(OptionVisitor& v, RunOptions& o);

}  // namespace vir::app
