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

/// Stands in a remedy for the driver that reads the recording, which this library does not know.
inline constexpr const char* kDriver = "DRIVER";

/// Puts `driver` ("csv", "bag", ...) where kDriver stands; empty: says what it stands for.
void nameDriver(const std::string& driver, Finding* finding);

/// The worst of them; note for none.
Severity worst(const std::vector<Finding>& findings);

/// "doubtful: IMU0: the accelerometer is in g (|a| 0.998 at rest): --set ...", one line.
std::string line(const Finding& finding);

}  // namespace vir::check
