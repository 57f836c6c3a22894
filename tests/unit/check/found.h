#pragma once
#include <string>
#include <vector>

#include "vir/check/finding.h"

namespace vir::check {

/// The kinds of all findings that are more than a note, in order.
inline std::vector<std::string> seriousKinds(const std::vector<Finding>& findings) {
  std::vector<std::string> out;
  for (const Finding& f : findings) {
    if (f.severity != Severity::note) out.push_back(f.kind);
  }
  return out;
}

using Kinds = std::vector<std::string>;

}  // namespace vir::check
