#pragma once
#include <cstdio>
#include <optional>
#include <string>

#include "vir/core/time.h"

namespace vir::estimator {

/// Times as people are told them: since the first image.
class Elapsed {
 public:
  /// The first image; later calls change nothing.
  void begin(TimeNs t) {
    if (!first_) first_ = t;
  }
  /// "14.0 s".
  std::string text(TimeNs t) const {
    char text[48];
    std::snprintf(text, sizeof text, "%.1f s", toSeconds(t - first_.value_or(0)));
    return text;
  }

 private:
  std::optional<TimeNs> first_;
};

}  // namespace vir::estimator
