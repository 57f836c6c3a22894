#pragma once
/// Dates and times of day as text.
#include <string>
#include <string_view>

namespace vir::tables {

/// Whole seconds and what stands behind the point, as written.
struct DateTime {
  long seconds = 0;           ///< since 1970 in UTC, or since midnight
  std::string_view fraction;  ///< digits; may be empty
};

/// `2024-05-01T12:00:00.123Z`: year first with `-`, `/` or `.`, or nothing between, or day first
/// with `.`; `T`, blanks, or one separator of columns; seconds may be missing; `Z`, `UTC`,
/// `+02:00`, `+0200`, `+02` or nothing behind. Years 1970 to 2261.
bool parseDateTime(std::string_view text, DateTime* out);
/// A day alone, as above.
bool isDate(std::string_view text);
/// `12:00:00.123`
bool parseTimeOfDay(std::string_view text, DateTime* out);

}  // namespace vir::tables
