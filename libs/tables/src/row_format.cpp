#include "vir/tables/row_format.h"

#include <algorithm>
#include <cctype>

#include "dates.h"
#include "vir/core/text.h"

namespace vir::tables {
namespace {

constexpr std::string_view kBlank = " \t\r\"";
constexpr long kDay = 86'400;

bool isDigit(char c) { return c >= '0' && c <= '9'; }

/// Every comma stands between digits and there is no point: `1,5`.
bool commasAreDecimal(std::string_view line) {
  if (line.find('.') != line.npos) return false;
  for (std::size_t at = line.find(','); at != line.npos; at = line.find(',', at + 1)) {
    if (at == 0 || at + 1 >= line.size() || !isDigit(line[at - 1]) || !isDigit(line[at + 1])) {
      return false;
    }
  }
  return true;
}

/// A number, or a time, with one comma and no point.
bool hasDecimalComma(std::string_view field) {
  return std::count(field.begin(), field.end(), ',') == 1 && commasAreDecimal(field) &&
         field.find_first_not_of("+-0123456789,eE:TZ ") == field.npos;
}

using Rows = std::vector<std::vector<std::string_view>>;

/// A few may be broken.
template <typename Test>
bool mostFields(const Rows& rows, std::size_t column, Test test) {
  std::size_t bad = 0;
  for (const auto& row : rows) {
    if (column < row.size() && test(row[column])) continue;
    if (++bad * 10 > rows.size()) return false;
  }
  return !rows.empty();
}

bool isDateTime(std::string_view text) {
  DateTime t;
  return parseDateTime(text, &t);
}

bool isTimeOfDay(std::string_view text) {
  DateTime t;
  return parseTimeOfDay(text, &t);
}

/// The time of day behind a date may have an offset.
bool isTimeBehindDate(std::string_view text) {
  return isDateTime("2000-01-01 " + std::string(text));
}

}  // namespace

void splitLine(std::string_view line, char separator, std::vector<std::string_view>* fields) {
  if (separator == ' ') {
    splitWords(line, kBlank, fields);
    return;
  }
  fields->clear();
  for (;;) {
    const std::size_t end = line.find(separator);
    fields->push_back(trimmed(line.substr(0, end), kBlank));
    if (end == std::string_view::npos) return;
    line.remove_prefix(end + 1);
  }
}

char separatorOf(std::string_view line) {
  if (line.find(';') != line.npos) return ';';
  if (line.find(',') == line.npos) return line.find('\t') != line.npos ? '\t' : ' ';
  line = trimmed(line, kBlank);
  if (!commasAreDecimal(line)) return ',';
  if (line.find('\t') != line.npos) return '\t';
  // Numbers only: a date has blanks of its own.
  const bool numbers = line.find_first_not_of("+-0123456789,eE ") == line.npos;
  return numbers && line.find(' ') != line.npos ? ' ' : ',';
}

ColumnKind RowFormat::kind(int column) const {
  const auto i = static_cast<std::size_t>(column);
  return column >= 0 && i < kinds.size() ? kinds[i] : ColumnKind::other;
}

RowFormat rowFormatOf(const std::vector<std::string>& lines, char separator) {
  RowFormat format;
  format.separator = separator;
  Rows rows(lines.size());
  std::size_t columns = 0;
  std::vector<long> commas, points;  // by column: a stamp may have a point beside them
  for (std::size_t r = 0; r < lines.size(); ++r) {
    splitLine(lines[r], separator, &rows[r]);
    columns = std::max(columns, rows[r].size());
    commas.resize(columns);
    points.resize(columns);
    for (std::size_t c = 0; c < rows[r].size(); ++c) {
      const std::string_view field = rows[r][c];
      commas[c] += hasDecimalComma(field) ? 1 : 0;
      // Not the points of a date.
      points[c] +=
          std::count(field.begin(), field.end(), '.') == 1 && isDigit(field.back()) ? 1 : 0;
    }
  }
  for (std::size_t c = 0; c < columns && separator != ','; ++c) {
    format.decimal_comma = format.decimal_comma || commas[c] > points[c];
  }
  for (std::size_t c = 0; c < columns; ++c) {
    if (mostFields(rows, c, isDateTime)) {
      format.kinds.push_back(ColumnKind::date);
    } else if (format.date_apart < 0 && mostFields(rows, c, isDate) &&
               mostFields(rows, c + 1, isTimeBehindDate)) {
      format.date_apart = static_cast<int>(c++);  // two columns become one
      format.kinds.push_back(ColumnKind::date);
    } else {
      format.kinds.push_back(mostFields(rows, c, isTimeOfDay) ? ColumnKind::clock
                                                              : ColumnKind::other);
    }
  }
  while (!format.kinds.empty() && format.kinds.back() == ColumnKind::other) format.kinds.pop_back();
  return format;
}

RowSplitter::RowSplitter(RowFormat format)
    : format_(std::move(format)), texts_(format_.kinds.size()), clocks_(format_.kinds.size()) {}

void RowSplitter::split(std::string_view line, std::vector<std::string_view>* fields) {
  if (format_.decimal_comma) {
    line_.assign(line);
    splitLine(line_, format_.separator, fields);
    for (const std::string_view field : *fields) {
      if (!hasDecimalComma(field)) continue;
      line_[static_cast<std::size_t>(field.data() - line_.data()) + field.find(',')] = '.';
    }
  } else {
    splitLine(line, format_.separator, fields);
  }
  const auto apart = static_cast<std::size_t>(format_.date_apart);
  if (format_.date_apart >= 0 && apart + 1 < fields->size()) {
    const std::string_view time = (*fields)[apart + 1];
    std::string_view& date = (*fields)[apart];
    date = {date.data(), static_cast<std::size_t>(time.data() + time.size() - date.data())};
    fields->erase(fields->begin() + format_.date_apart + 1);
  }
  for (std::size_t c = 0; c < texts_.size() && c < fields->size(); ++c) {
    if (format_.kinds[c] == ColumnKind::other) continue;
    std::string_view& field = (*fields)[c];
    DateTime t;
    if (format_.kinds[c] == ColumnKind::date) {
      if (!parseDateTime(field, &t)) continue;
    } else {
      if (!parseTimeOfDay(field, &t)) continue;
      Clock& clock = clocks_[c];
      if (t.seconds < clock.last_s - kDay / 2) ++clock.day;
      // A late row from before midnight.
      if (clock.day > 0 && t.seconds > clock.last_s + kDay / 2) --clock.day;
      clock.last_s = t.seconds;
      t.seconds += clock.day * kDay;
    }
    texts_[c] = std::to_string(t.seconds);
    if (!t.fraction.empty()) texts_[c].append(".").append(t.fraction);
    field = texts_[c];
  }
}

}  // namespace vir::tables
