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

void nameDriver(const std::string& driver, Finding* finding) {
  const std::size_t at = finding->remedy.find(kDriver);
  if (at == std::string::npos) return;
  if (driver.empty()) {
    finding->remedy += "; DRIVER is what imported it: euroc, csv, bag or rosbag2";
  } else {
    finding->remedy.replace(at, std::string(kDriver).size(), driver);
  }
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
