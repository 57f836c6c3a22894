/// Which column holds the stamps, and in what unit.
#include <algorithm>

#include "units.h"
#include "vir/core/parse_number.h"
#include "vir/tables/layout.h"

namespace vir::tables {
namespace {

/// When it was measured; a `time` beside it is when it came in.
constexpr const char* kHeaderStamp = "header_stamp";

/// What times are called, best first; a unit may stand behind.
const std::vector<std::string>& stampNames() {
  static const std::vector<std::string> names{kHeaderStamp,
                                              "timestamp",
                                              "stamp",
                                              "time",
                                              "t",
                                              "time_stamp",
                                              "ts",
                                              "datetime",
                                              "date_time",
                                              "date",
                                              "utc",
                                              "utc_time",
                                              "time_utc",
                                              "timestamp_utc",
                                              "elapsed",
                                              "elapsed_time",
                                              "time_elapsed",
                                              "time_since_start",
                                              "epoch",
                                              "unix_time",
                                              "unixtime",
                                              "system_time",
                                              "sensor_time",
                                              "local_time",
                                              "sample_time",
                                              "loggingtime",
                                              "rosbagtimestamp"};
  return names;
}

/// `name` behind `base`: nothing, or a unit. `plain`: nothing.
bool isStampName(const std::string& name, const std::string& base, bool plain) {
  if (name.compare(0, base.size(), base) != 0) return false;
  if (plain) return name.size() == base.size();
  std::string_view rest = std::string_view(name).substr(base.size());
  for (const std::string_view front : {"_in_", "_"}) {
    if (rest.substr(0, front.size()) != front) continue;
    rest.remove_prefix(front.size());
    break;
  }
  return stampUnitOfText(rest).has_value();
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
  if (!layout.units[i].empty()) return stampUnitOfText(layout.units[i]);
  const std::string& name = layout.names[i];
  const std::size_t at = name.rfind('_');
  if (at != name.npos) return stampUnitOfText(std::string_view(name).substr(at + 1));
  for (const std::string& base : stampNames()) {
    if (isStampName(name, base, false)) return stampUnitOfText(name.substr(base.size()));
  }
  return std::nullopt;
}

/// Drivers that know no time leave the stamp at 0.
bool moves(const Layout& layout, std::size_t column) {
  const std::vector<std::string> stamps = layout.column(column);
  return stamps.size() < 2 || std::any_of(stamps.begin(), stamps.end(), [&](const std::string& s) {
           return s != stamps.front();
         });
}

}  // namespace

int namedStampColumn(const Layout& layout) {
  const auto find = [&](bool plain, bool rest_of_seconds) {
    for (const std::string& base : stampNames()) {
      for (std::size_t i = 0; i < layout.names.size(); ++i) {
        const std::string& name = layout.names[i];
        // `stamp_nsecs` is a time only where there is no `stamp_secs`.
        const bool rest = name.size() > 4 && name.find("nsec", name.size() - 5) != name.npos;
        if (rest != rest_of_seconds || !isStampName(name, base, plain)) continue;
        if (name != kHeaderStamp || moves(layout, i)) return static_cast<int>(i);
      }
    }
    return -1;
  };
  int column = find(true, false);
  // `TimeUS,I,GyrX,...,T`: there T is a temperature.
  const bool perhaps = column > 0 && layout.names[static_cast<std::size_t>(column)] == "t";
  const int with_unit = column < 0 || perhaps ? find(false, false) : -1;
  if (with_unit >= 0) column = with_unit;
  if (column < 0) column = layout.find({"secs", "sec", "seconds", "seconds_elapsed"});
  if (column < 0) column = find(false, true);
  return column >= 0 ? column : layout.find({"nsec"});
}

int stampColumn(const Layout& layout) {
  const int named = namedStampColumn(layout);
  if (named >= 0) return named;
  for (std::size_t i = 0; i < layout.kinds.size(); ++i) {
    if (layout.kinds[i] != ColumnKind::other) return static_cast<int>(i);
  }
  const bool second = layout.columns > 1 && onlyCounts(layout.column(0)) &&
                      guessUnit(layout.column(1), 0.05).unix_time;
  return second ? 1 : 0;
}

std::string stampRemark(const Layout& layout, int column) {
  switch (layout.kind(column)) {
    case ColumnKind::date:
      return "the stamps are dates, in UTC where they name no offset";
    case ColumnKind::clock:
      return "the stamps are times of day without a date: they count from the midnight before the "
             "first row";
    case ColumnKind::other:
      break;
  }
  const int other = layout.find({"time"});
  if (other >= 0 && layout.find({kHeaderStamp}) == column) {
    return "the stamps are those of header.stamp, not of time, when it was received; in " +
           std::string(name(stampUnit(layout, column, 0.01).unit));
  }
  return {};
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
  const ColumnKind kind = layout.kind(index);
  if (kind != ColumnKind::other) return {StampUnit::seconds, kind == ColumnKind::date, true};
  if (nanosecondColumn(layout, index) >= 0) return {StampUnit::seconds, false, true};
  return guessUnit(layout.column(static_cast<std::size_t>(std::max(index, 0))), typical_step_s,
                   unitNamed(layout, index));
}

}  // namespace vir::tables
