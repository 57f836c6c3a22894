#include "vir/ranging/survey_table.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "vir/core/parse_number.h"
#include "vir/core/text.h"
#include "vir/tables/anchor_names.h"
#include "vir/tables/layout.h"

namespace vir::ranging {
namespace {

constexpr std::uint64_t kLargestId = std::numeric_limits<std::int32_t>::max();
/// Farther than anything on Earth [m].
constexpr double kFarthest = 1e7;

struct Columns {
  int id = 0, p[3] = {1, 2, 3}, sigma = 4;
  double unit_m = 1;
  std::size_t needed() const {
    return static_cast<std::size_t>(std::max({id, p[0], p[1], p[2]})) + 1;
  }
};

double unitOf(const std::string& name, const std::string& line_of) {
  const std::string unit = lowerCase(name);
  if (unit.empty() || unit == "m") return 1;
  if (unit == "mm") return 0.001;
  if (unit == "cm") return 0.01;
  if (unit == "ft") return 0.3048;
  throw SurveyTableError(line_of + ": the unit [" + name +
                         "] is not known; allowed: m, cm, mm, ft");
}

Columns columnsOf(const tables::Layout& layout, const std::string& name) {
  Columns c;
  const auto find = [&](const char* axis) {
    const std::string a = axis;
    const int exact =
        layout.find({a, a + "_m", "pos_" + a, "position_" + a, "p_" + a, a + "_mm", a + "_cm"});
    if (exact >= 0) return exact;
    // `z in the ground truth's frame [m]`
    const auto begins =
        std::find_if(layout.names.begin(), layout.names.end(),
                     [&](const std::string& n) { return n.rfind(a + "_", 0) == 0; });
    return begins == layout.names.end() ? -1 : static_cast<int>(begins - layout.names.begin());
  };
  c.id = layout.find({"id", "anchor", "anchor_id", "name", "beacon", "tag", "label", "node"});
  c.p[0] = find("x");
  c.p[1] = find("y");
  c.p[2] = find("z");
  c.sigma = layout.find({"sigma", "sigma_m", "std", "std_m", "accuracy", "accuracy_m"});
  if (c.id < 0 || c.p[0] < 0 || c.p[1] < 0 || c.p[2] < 0) {
    throw SurveyTableError(name +
                           ": the header names no id, x, y or z; needed: id,x,y,z, and "
                           "sigma where it is known");
  }
  const auto x = static_cast<std::size_t>(c.p[0]);
  if (x < layout.units.size()) c.unit_m = unitOf(layout.units[x], name);
  const std::string& named = layout.names[x];
  for (const char* unit : {"mm", "cm"}) {
    const std::string end = std::string("_") + unit;
    if (named.size() > end.size() && named.compare(named.size() - end.size(), end.size(), end) == 0)
      c.unit_m = unitOf(unit, name);
  }
  return c;
}

/// False for what is no id.
bool idOf(std::string_view text, const AnchorNumbers& numbers, std::uint64_t* id) {
  const auto known = numbers.find(tables::utf8Name(text));
  if (known != numbers.end()) {
    *id = known->second;
    return true;
  }
  const bool prefixed = text.size() > 2 && text[0] == '0' && (text[1] == 'x' || text[1] == 'X');
  if (prefixed) return parseNumber(text.substr(2), id, 16) && *id <= kLargestId;
  const std::size_t point = text.find('.');
  const bool whole = point == text.npos || text.find_first_not_of('0', point + 1) == text.npos;
  if (whole && parseNumber(text.substr(0, point), id)) return *id <= kLargestId;
  return parseNumber(text, id, 16) && *id <= kLargestId;
}

SurveyedAnchor anchorOf(const std::vector<std::string_view>& fields, const Columns& c,
                        const AnchorNumbers& numbers, const std::string& where) {
  if (fields.size() < c.needed()) {
    throw SurveyTableError(where + ": expected id,x,y,z, and sigma where it is known");
  }
  SurveyedAnchor out;
  const std::string_view id = fields[static_cast<std::size_t>(c.id)];
  if (!idOf(id, numbers, &out.id)) {
    throw SurveyTableError(where + ": '" + std::string(id) +
                           "' is no anchor; allowed: a number, 0x.., a name that the recording "
                           "gives one (" +
                           (numbers.empty() ? "it gives none" : "see its ini") + ")");
  }
  const auto number = [&](int column, double* v) {
    const std::string_view text = fields[static_cast<std::size_t>(column)];
    if (parseFinite(text, v) && std::abs(*v) * c.unit_m < kFarthest) return;
    throw SurveyTableError(where + ": '" + std::string(text) + "' is no length in metres");
  };
  for (int i = 0; i < 3; ++i) {
    number(c.p[i], &out.p_S[i]);
    out.p_S[i] *= c.unit_m;
  }
  const bool has_sigma = c.sigma >= 0 && static_cast<std::size_t>(c.sigma) < fields.size() &&
                         !fields[static_cast<std::size_t>(c.sigma)].empty();
  if (!has_sigma) return out;
  number(c.sigma, &out.sigma_m);
  out.sigma_m *= c.unit_m;
  if (out.sigma_m >= 1e-4 && out.sigma_m <= 1000) return out;
  throw SurveyTableError(where + ": sigma is " +
                         std::string(fields[static_cast<std::size_t>(c.sigma)]) +
                         "; allowed: from 0.0001 to 1000 m, empty = 0.05");
}

struct Line {
  int number = 0;
  std::string_view text;  ///< without `#`
  bool comment = false, header = false;
};

/// A line that names columns: three words or more, none a number.
bool namesColumns(std::string_view text) {
  std::vector<std::string_view> fields;
  tables::splitLine(text, tables::separatorOf(text), &fields);
  if (fields.size() < 3) return false;
  double v = 0;
  return std::none_of(fields.begin(), fields.end(),
                      [&](std::string_view f) { return parseNumber(f, &v); });
}

/// Of those that are not empty. A table has one header, before its data, with or without `#`.
std::vector<Line> linesOf(std::string_view text) {
  std::vector<Line> out;
  bool data = false;
  std::size_t from = 0;
  for (int number = 1; from < text.size(); ++number) {
    const std::size_t end = std::min(text.find('\n', from), text.size());
    Line line{number, trimmed(text.substr(from, end - from))};
    from = end + 1;
    if (line.text.empty()) continue;
    line.comment = line.text[0] == '#' || line.text[0] == '%';
    if (line.comment) line.text = trimmed(line.text.substr(1));
    line.header = !data && namesColumns(line.text);
    data = data || (!line.comment && !line.header);
    out.push_back(line);
  }
  return out;
}

tables::Layout layoutOfHeader(std::string_view header, char separator) {
  std::vector<std::string_view> fields;
  tables::splitLine(header, tables::separatorOf(header), &fields);
  std::string row;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (i > 0) row += separator;
    row += '0';
  }
  std::string names;
  for (const std::string_view f : fields) {
    if (!names.empty()) names += separator;
    names += f;
  }
  return tables::layoutOfText(names + "\n" + row + "\n");
}

}  // namespace

std::string anchorNumbersText(const AnchorNumbers& numbers) {
  std::string out;
  for (const auto& [name, number] : numbers) {
    if (!out.empty()) out += ' ';
    for (const char c : name) out += c == ' ' ? "%20" : c == '%' ? "%25" : std::string(1, c);
    out += "=" + std::to_string(number);
  }
  return out;
}

AnchorNumbers anchorNumbers(const std::string& text) {
  AnchorNumbers out;
  for (const std::string_view word : wordsOf(text)) {
    const std::size_t at = word.rfind('=');
    std::uint64_t number = 0;
    if (at == word.npos || at == 0 || !parseNumber(word.substr(at + 1), &number)) {
      throw std::runtime_error("[Ranges] anchor_names: '" + std::string(word) +
                               "' is no name=number");
    }
    std::string name(word.substr(0, at));
    for (std::size_t i = 0; (i = name.find('%', i)) != std::string::npos; ++i) {
      const std::string code = name.substr(i, 3);
      if (code == "%20" || code == "%25") name.replace(i, 3, code == "%20" ? " " : "%");
    }
    out[name] = number;
  }
  return out;
}

std::vector<SurveyedAnchor> surveyFromText(std::string_view text, const std::string& name,
                                           const AnchorNumbers& numbers) {
  const std::vector<Line> lines = linesOf(text);
  const auto data = std::find_if(lines.begin(), lines.end(),
                                 [](const Line& l) { return !l.comment && !l.header; });
  if (data == lines.end()) {
    throw SurveyTableError(name + " holds no anchor; needed: lines id,x,y,z,sigma");
  }
  const char separator = tables::separatorOf(data->text);
  Columns columns;
  for (auto l = lines.begin(); l != data; ++l) {
    if (l->header) columns = columnsOf(layoutOfHeader(l->text, separator), name);
  }
  std::vector<SurveyedAnchor> out;
  std::set<std::uint64_t> ids;
  std::vector<std::string_view> fields;
  for (auto l = data; l != lines.end(); ++l) {
    if (l->comment) continue;
    tables::splitLine(l->text, separator, &fields);
    const std::string where = name + ":" + std::to_string(l->number);
    out.push_back(anchorOf(fields, columns, numbers, where));
    if (!ids.insert(out.back().id).second) {
      throw SurveyTableError(where + ": anchor " + std::to_string(out.back().id) +
                             " is there already; allowed: one place for every anchor");
    }
  }
  return out;
}

}  // namespace vir::ranging
