/// Which column holds the stamps, and in what unit.
#include <algorithm>

#include "vir/core/parse_number.h"
#include "vir/tables/layout.h"

namespace vir::tables {
namespace {

const std::vector<std::string>& stampNames() {
  static const std::vector<std::string> names{"timestamp",
                                              "stamp",
                                              "time",
                                              "t",
                                              "timestamp_ns",
                                              "timestamp_us",
                                              "time_ns",
                                              "timestamp_ms",
                                              "time_us",
                                              "time_ms",
                                              "timestamp_s",
                                              "time_s",
                                              "t_ns",
                                              "t_us",
                                              "t_ms",
                                              "t_s",
                                              "secs",
                                              "sec",
                                              "header_stamp",
                                              "stamp_ns",
                                              "header_stamp_secs",
                                              "header_stamp_sec",
                                              "stamp_secs",
                                              "stamp_sec",
                                              "time_secs",
                                              "time_sec",
                                              "seconds",
                                              "nsec"};
  return names;
}

/// 0 1 2 3 ..., or from 1 on.
bool onlyCounts(const std::vector<std::string>& column) {
  if (column.size() < 3) return false;
  long first = 0;
  if (!parseNumber(column.front(), &first) || first < 0 || first > 1) return false;
  for (std::size_t i = 1; i < column.size(); ++i) {
    long value = 0;
    if (!parseNumber(column[i], &value) || value != first + static_cast<long>(i)) return false;
  }
  return true;
}

std::optional<StampUnit> unitNamed(const Layout& layout, int index) {
  const auto i = static_cast<std::size_t>(index);
  if (i >= layout.names.size()) return std::nullopt;
  const std::string& name = layout.names[i];
  const auto ends = [&](const std::string& end) {
    return name.size() > end.size() && name.compare(name.size() - end.size(), end.size(), end) == 0;
  };
  for (const StampUnit unit : {StampUnit::nanoseconds, StampUnit::microseconds,
                               StampUnit::milliseconds, StampUnit::seconds}) {
    if (layout.units[i] == tables::name(unit) || ends(std::string("_") + tables::name(unit))) {
      return unit;
    }
  }
  return std::nullopt;
}

}  // namespace

int stampColumn(const Layout& layout) {
  const int named = layout.find(stampNames());
  if (named >= 0) return named;
  const bool second = layout.columns > 1 && onlyCounts(layout.column(0)) &&
                      guessUnit(layout.column(1), 0.05).unix_time;
  return second ? 1 : 0;
}

int nanosecondColumn(const Layout& layout, int stamp) {
  const auto i = static_cast<std::size_t>(std::max(stamp, 0));
  if (i >= layout.names.size()) return -1;
  const std::string& name = layout.names[i];
  for (const char* end : {"secs", "sec", "seconds"}) {
    const std::size_t at = name.rfind(end);
    if (at == std::string::npos || at + std::string(end).size() != name.size()) continue;
    // Not the nanoseconds themselves.
    if (at > 0 && name[at - 1] != '_') continue;
    const std::string front = name.substr(0, at);
    return layout.find({front + "n" + end, front + "nano" + end, front + "nanoseconds"});
  }
  return -1;
}

UnitGuess stampUnit(const Layout& layout, int index, double typical_step_s) {
  if (nanosecondColumn(layout, index) >= 0) return {StampUnit::seconds, false, true};
  return guessUnit(layout.column(static_cast<std::size_t>(std::max(index, 0))), typical_step_s,
                   unitNamed(layout, index));
}

}  // namespace vir::tables
