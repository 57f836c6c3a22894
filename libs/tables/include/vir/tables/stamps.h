#pragma once
/// Stamps as text in any notation and unit, exact to the nanosecond.
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "vir/core/time.h"

namespace vir::tables {

enum class StampUnit { seconds, milliseconds, microseconds, nanoseconds };

/// "s", "ms", "us", "ns".
const char* name(StampUnit unit);

/// Decimal digits with or without point and exponent; digits below the nanosecond are rounded.
/// False for anything else, and for what 64 bits of nanoseconds cannot hold. Never by way of a
/// double, whose steps at today's Unix time are 0.2 us.
bool parseStamp(std::string_view text, StampUnit unit, TimeNs* t);
/// Adds the nanoseconds that belong to whole seconds in `t`. False, and nothing added, for what is
/// no number from 0 to 999999999, or too late for 64 bits.
bool addNanoseconds(std::string_view text, TimeNs* t);

struct UnitGuess {
  StampUnit unit = StampUnit::nanoseconds;
  bool unix_time = false;  ///< the stamps are dates of 2001 to 2100
  bool sure = false;       ///< else neither date, nor header, nor step decided
};

/// The unit of a column from its first stamps, in the order of the file: the one in which they are
/// dates a plausible step apart, else the one whose steps are nearest to `typical_step_s`. A header
/// that names a unit decides only where both leave it open: headers are copied, stamps converted.
UnitGuess guessUnit(const std::vector<std::string>& stamps, double typical_step_s,
                    std::optional<StampUnit> header = std::nullopt);

}  // namespace vir::tables
