#include "vir/check/finding.h"

#include <algorithm>

namespace vir::check {

const char* name(Severity severity) {
  switch (severity) {
    case Severity::note:
      return "note";
    case Severity::doubtful:
      return "doubtful";
    case Severity::unusable:
      break;
  }
  return "unusable";
}

Severity worst(const std::vector<Finding>& findings) {
  Severity out = Severity::note;
  for (const Finding& f : findings) out = std::max(out, f.severity);
  return out;
}

std::string line(const Finding& f) {
  std::string out = std::string(name(f.severity)) + ": " + f.stream + ": " + f.what;
  if (!f.evidence.empty()) out += " (" + f.evidence + ")";
  if (!f.remedy.empty()) out += ": " + f.remedy;
  return out;
}

}  // namespace vir::check
