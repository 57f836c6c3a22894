#pragma once
/// What a look at a recording brought to light.
#include <string>
#include <vector>

namespace vir::check {

enum class Severity { note, doubtful, unusable };
const char* name(Severity severity);

struct Finding {
  Severity severity = Severity::note;
  std::string kind;      ///< for programs: "acc_in_g", "stamps_in_ms", ...
  std::string stream;    ///< sensor label
  std::string what;      ///< the conclusion, in one clause
  std::string evidence;  ///< what was measured, with units
  std::string remedy;    ///< what to do; empty: nothing
};

/// The worst of them; note for none.
Severity worst(const std::vector<Finding>& findings);

/// "doubtful: IMU0: the accelerometer is in g (|a| 0.998 at rest): --set ...", one line.
std::string line(const Finding& finding);

}  // namespace vir::check
