#pragma once
/// From a line of a table to its fields.
#include <string>
#include <string_view>
#include <vector>

namespace vir::tables {

/// Splits a line at `separator`; ' ' stands for any run of blanks and tabs. Fields come without
/// surrounding blanks and quotes.
void splitLine(std::string_view line, char separator, std::vector<std::string_view>* fields);

/// The separator of a line of numbers: ';' (beside which commas are decimal points), ',' or a tab
/// where there is one, else ' '. A tab, or blanks, where all commas are decimal: between digits,
/// and no point anywhere.
char separatorOf(std::string_view line);

/// What a column holds.
enum class ColumnKind {
  other,
  date,   ///< date and time of day: `2024-05-01T12:00:00.123Z`, `20240501T120000`, `1.5.2024 12:00`
  clock,  ///< time of day: `12:00:00.123`
};

struct RowFormat {
  char separator = ' ';
  bool decimal_comma = false;
  /// The column of a date whose time of day is in the column behind: both are one. -1: none.
  int date_apart = -1;
  std::vector<ColumnKind> kinds;  ///< by column, those behind are `other`

  ColumnKind kind(int column) const;
};

/// By the first lines of data, all of one separator.
RowFormat rowFormatOf(const std::vector<std::string>& lines, char separator);

/// Fields as plain numbers: decimal commas become points, dates seconds since 1970 (UTC where they
/// name no offset), times of day seconds since the first row's midnight. What cannot be read stays
/// as it is.
class RowSplitter {
 public:
  explicit RowSplitter(RowFormat format);
  /// The fields are valid until the next call, and as long as the line.
  void split(std::string_view line, std::vector<std::string_view>* fields);

 private:
  /// A day has passed where a time of day falls by more than half of it.
  struct Clock {
    long day = 0, last_s = -1;
  };

  RowFormat format_;
  std::string line_;
  std::vector<std::string> texts_;
  std::vector<Clock> clocks_;
};

}  // namespace vir::tables
