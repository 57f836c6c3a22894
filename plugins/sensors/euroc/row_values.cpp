#include "row_values.h"

#include <cmath>
#include <cstdio>

#include "vir/core/time_bounds.h"
#include "vir/tables/unknown_units.h"

namespace vir::euroc {

Stamps stampsOf(const std::string& path, const tables::Layout& layout, int column,
                double typical_step_s, bool seconds_expected, ProblemLog* log) {
  const tables::UnitGuess guess = tables::stampUnit(layout, column, typical_step_s);
  const auto expected =
      seconds_expected ? tables::StampUnit::seconds : tables::StampUnit::nanoseconds;
  const Stamps stamps{column, guess.sure ? guess.unit : expected,
                      tables::nanosecondColumn(layout, column)};
  const std::string unknown = tables::unknownStampUnit(layout, column, stamps.unit);
  if (!unknown.empty()) {
    log->note(path + ": " + unknown);
    log->count("unknown_unit");
    return stamps;
  }
  const std::string remark = tables::stampRemark(layout, column);
  if (!remark.empty()) {
    log->note(path + ": " + remark);
  } else if (stamps.unit != expected) {
    log->note(path + ": the stamps are in " + tables::name(stamps.unit) + ", taken as such");
  }
  return stamps;
}

bool enough(const Fields& f, int last, RowFault* fault) {
  if (static_cast<int>(f.size()) > last) return true;
  *fault = {"malformed",
            "has " + std::to_string(f.size()) + " columns, needs " + std::to_string(last + 1)};
  return false;
}

const std::string_view& at(const Fields& f, int column) {
  return f[static_cast<std::size_t>(column)];
}

bool stamp(const Fields& f, const Stamps& stamps, TimeNs* t, RowFault* fault) {
  const std::string_view text = at(f, stamps.column);
  bool is_time = tables::parseStamp(text, stamps.unit, t);
  if (stamps.nanoseconds >= 0) {
    const auto column = static_cast<std::size_t>(stamps.nanoseconds);
    is_time = is_time && column < f.size() && tables::addNanoseconds(f[column], t);
  }
  if (is_time && isStamp(*t)) {
    *t += stamps.offset;
    if (isStamp(*t)) return true;
    *fault = {"before_zero", "`" + std::string(text.substr(0, 40)) +
                                 "` is no time any more with the offset of the settings"};
    return false;
  }
  if (is_time && *t >= 0) {
    *fault = {"implausible", "`" + std::string(text.substr(0, 40)) + "` is a time after 2099"};
    return false;
  }
  if (is_time) {
    *fault = {"before_zero", "`" + std::string(text.substr(0, 40)) +
                                 "` is a time before 0; add the same to all stamps of all tables"};
    return false;
  }
  const bool ns = stamps.unit == tables::StampUnit::nanoseconds;
  *fault = {"malformed", "`" + std::string(text.substr(0, 40)) +
                             (ns ? "` is not a whole number of nanoseconds"
                                 : std::string("` is not a time in ") + tables::name(stamps.unit))};
  return false;
}

bool value(const Fields& f, int column, double* out, RowFault* fault) {
  const std::string_view field = at(f, column);
  const std::string name = "column " + std::to_string(column + 1);
  const std::string text(field.substr(0, 40));
  if (!parseNumber(field, out)) {
    const bool comma = text.find(',') != std::string::npos;
    *fault = {"malformed", name + ": `" + text + "` is not a number" +
                               (comma ? " (a decimal comma? numbers need a point)" : "")};
    return false;
  }
  if (std::isfinite(*out)) return true;
  *fault = {"not_finite", name + " is " + text};
  return false;
}

bool vector(const Fields& f, const int columns[3], Vec3* out, RowFault* fault) {
  for (int i = 0; i < 3; ++i) {
    if (!value(f, columns[i], &(*out)[i], fault)) return false;
  }
  return true;
}

bool implausible(RowFault* fault, const std::string& text) {
  *fault = {"implausible", text};
  return false;
}
bool anchorId(std::string_view field, tables::AnchorNames* names, int* id, RowFault* fault) {
  if (names->numberOf(field, id)) return true;
  *fault = {"malformed", "`" + std::string(field.substr(0, 40)) +
                             "` is no anchor's id (a number, or a name of letters and digits)"};
  return false;
}

void sayUnit(const std::string& path, const char* what, double factor, const char* unit,
             ProblemLog* log) {
  if (factor == 1) return;
  char text[160];
  std::snprintf(text, sizeof text, ": the %s was multiplied by %.6g to be in %s", what, factor,
                unit);
  log->note(path + text);
}

void sayByPosition(const std::string& path, const tables::Layout& layout,
                   const tables::Taken& taken, bool by_units, ProblemLog* log) {
  const std::string text = tables::takenByPosition(layout, taken, by_units);
  if (text.empty()) return;
  log->note(path + ": " + text);
  if (!by_units) log->count("table_by_position");
}

}  // namespace vir::euroc
