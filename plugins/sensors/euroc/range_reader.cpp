/// Tables of ranges.
#include <algorithm>
#include <set>

#include "input_error.h"
#include "readers.h"
#include "row_values.h"
#include "vir/core/text.h"
#include "vir/core/text_file.h"
#include "vir/tables/ranges.h"
#include "vir/tables/unknown_units.h"

namespace vir::euroc {
namespace {

constexpr double kMaxRange = 1e5;  // m; beyond it a number is no measurement
constexpr double kRangeStep =
    0.05;  // s, between rows, to tell the unit of stamps that are no dates

/// What a row of ranges is read with.
struct RangeTable {
  tables::RangeColumns c;
  Stamps stamps;
  tables::AnchorNames* names;
  ProblemLog* log;
  std::string path;
  bool between_anchors = false;  // the column of antennas has anchors too
};

/// A word or a number; a share counts as true from a half on.
bool flag(const Fields& f, int column, bool* out, RowFault* fault) {
  const std::string word = lowerCase(std::string(at(f, column)));
  for (const char* yes : {"true", "yes", "t", "y", "valid", "ok"}) {
    if (word == yes) return *out = true;
  }
  *out = false;
  for (const char* no : {"false", "no", "f", "n", "invalid"}) {
    if (word == no) return true;
  }
  double v = 0;
  if (!value(f, column, &v, fault)) return false;
  *out = v >= 0.5;
  return true;
}

/// Place and noise, as far as the table holds them; what it leaves out in a row is not said.
bool parseRadio(const Fields& f, const RangeTable& table, RangeRow* row, RowFault* fault) {
  const tables::RangeColumns& c = table.c;
  if (c.antenna >= 0) row->antenna = std::string(at(f, c.antenna));
  Vec3 place;
  if (c.hasLever()) {
    if (!vector(f, c.lever, &place, fault)) return false;
    row->place = c.lever_unit_m == 1 ? place : Vec3(c.lever_unit_m * place);
  }
  RowFault unsaid;
  if (c.hasPlace() && vector(f, c.place, &place, &unsaid)) {
    row->anchor_place = c.place_unit_m * place;
  }
  if (c.sigma < 0 || c.sigma >= static_cast<int>(f.size())) return true;
  double sigma = 0;
  if (value(f, c.sigma, &sigma, &unsaid) && sigma > 0) {
    row->sigma_m = c.sigma_unit_m == 1 ? sigma : c.sigma_unit_m * sigma;
  } else {
    table.log->count("range_without_noise");
  }
  return true;
}

bool parseSight(const Fields& f, const RangeTable& table, RowFault* fault) {
  const int column = table.c.nlos >= 0 ? table.c.nlos : table.c.los;
  bool yes = false;
  if (column < 0 || column >= static_cast<int>(f.size())) return true;
  if (!flag(f, column, &yes, fault)) return false;
  if (yes != (column == table.c.nlos)) return true;
  const char* counter = "range_without_line_of_sight";
  if (table.log->get(counter) == 0) {
    table.log->note(table.path + ": ranges that it calls blocked (no line of sight) are kept");
  }
  table.log->count(counter);
  return true;
}

/// All but anchor and range. A fault without a text is only counted.
bool parseRest(const Fields& f, const RangeTable& table, RangeRow* row, RowFault* fault) {
  bool valid = true;
  if (table.c.valid >= 0 && !flag(f, table.c.valid, &valid, fault)) return false;
  if (!valid) {
    *fault = {"not_valid", ""};
    return false;
  }
  return parseRadio(f, table, row, fault) && parseSight(f, table, fault);
}

bool plausible(const Fields& f, int column, double range_m, bool differs, RowFault* fault) {
  if ((differs ? -kMaxRange : 0) <= range_m && range_m <= kMaxRange) return true;
  return implausible(fault, "a range of " + std::string(at(f, column)) + " m");
}

bool parseRange(const Fields& f, const RangeTable& table, RangeRow* row, RowFault* fault) {
  const tables::RangeColumns& c = table.c;
  if (!enough(f, c.last(), fault) || !stamp(f, table.stamps, &row->t, fault) ||
      !value(f, c.range, &row->range_m, fault) ||
      !anchorId(at(f, c.anchor), table.names, &row->anchor, fault)) {
    return false;
  }
  if (c.reference >= 0) {
    int reference = 0;
    if (!anchorId(at(f, c.reference), table.names, &reference, fault)) return false;
    if (reference == row->anchor) {
      return implausible(fault, "a difference of ranges to one and the same anchor");
    }
    row->reference = reference;
  }
  if (c.unit_m != 1) row->range_m *= c.unit_m;
  return plausible(f, c.range, row->range_m, c.reference >= 0, fault) &&
         parseRest(f, table, row, fault);
}

/// One of the two ends of a range between anchors.
bool parseEnd(const Fields& f, int column, const RangeTable& table, int* anchor, RowFault* fault) {
  const std::string name = "column " + std::to_string(column + 1);
  if (at(f, column).empty()) {
    *fault = {"malformed", name + " is empty"};
    return false;
  }
  if (anchorId(at(f, column), table.names, anchor, fault)) return true;
  fault->text = name + ": " + fault->text;
  return false;
}

/// From one anchor to another.
bool parseBetween(const Fields& f, const RangeTable& table, RangeRow* row, RowFault* fault) {
  const tables::RangeColumns& c = table.c;
  const auto parse = [&] {
    int from = 0;
    if (!enough(f, c.last(), fault) || !stamp(f, table.stamps, &row->t, fault) ||
        !parseEnd(f, c.antenna, table, &from, fault) ||
        !parseEnd(f, c.anchor, table, &row->anchor, fault) ||
        !value(f, c.range, &row->range_m, fault)) {
      return false;
    }
    if (from == row->anchor) {
      return implausible(fault, "columns " + std::to_string(c.antenna + 1) + " and " +
                                    std::to_string(c.anchor + 1) + ": both ends are the anchor " +
                                    std::string(at(f, c.anchor)));
    }
    row->from = from;
    if (c.unit_m != 1) row->range_m *= c.unit_m;
    if (plausible(f, c.range, row->range_m, false, fault)) return true;
    fault->text = "column " + std::to_string(c.range + 1) + ": " + fault->text;
    return false;
  };
  if (parse()) return parseRest(f, table, row, fault);
  fault->text +=
      "; a row needs a stamp, two different anchors and how far they are apart [m]: "
      "correct it, or leave it out";
  return false;
}

/// The range to one anchor of a row that holds several.
bool parseOneOf(const Fields& f, const RangeTable& table, const tables::AnchorColumn& to,
                RangeRow* row, RowFault* fault) {
  const auto column = static_cast<std::size_t>(to.column);
  const bool first = &to == &table.c.wide.front();
  // What is wrong with the row is said once.
  RowFault again;
  RowFault* of_row = first ? fault : &again;
  fault->kind = "not_measured";
  if (!enough(f, table.c.last(), of_row) || !stamp(f, table.stamps, &row->t, of_row)) return false;
  double v = 0;
  if (column >= f.size() || f[column].empty() || (parseNumber(f[column], &v) && !(v > 0))) {
    return false;
  }
  if (!value(f, to.column, &row->range_m, fault) ||
      !anchorId(to.anchor, table.names, &row->anchor, fault)) {
    return false;
  }
  row->range_m *= to.unit_m;
  return plausible(f, to.column, row->range_m, false, fault) && parseRest(f, table, row, fault);
}

std::unique_ptr<RowStream<RangeRow>> open(const std::string& path, const Units& units,
                                          tables::AnchorNames* names, ProblemLog* log,
                                          bool between_anchors) {
  const tables::Layout layout = tables::layoutOf(path);
  RangeTable table{tables::rangeColumns(layout), {}, names, log, path, between_anchors};
  tables::RangeColumns& c = table.c;
  if (units.range > 0 && !c.flight) {
    c.unit_m = units.range;
    for (tables::AnchorColumn& to : c.wide) to.unit_m = units.range;
  }
  c.unit_m *= units.range_factor;
  for (tables::AnchorColumn& to : c.wide) to.unit_m *= units.range_factor;
  const bool wide = !c.wide.empty();
  sayUnit(path, "range", wide ? c.wide.front().unit_m : c.unit_m, "m", log);
  table.stamps = stampsOf(path, layout, c.stamp, kRangeStep, false, log);
  table.stamps.offset = units.range_offset;
  std::vector<int> lengths{c.lever[0], c.sigma};
  if (!wide) lengths.push_back(c.range);
  for (const tables::AnchorColumn& to : c.wide) lengths.push_back(to.column);
  const std::string unknown = units.range > 0 ? "" : tables::unknownUnits(layout, lengths);
  if (!unknown.empty()) {
    log->note(path + ": " + unknown);
    log->count("unknown_unit");
  }
  // Whose the columns are is said for a robot.
  for (std::size_t i = 0; i < c.remarks.size() && !between_anchors; ++i) {
    log->note(path + ": " + c.remarks[i]);
  }
  const std::string why_not = tables::whyNoRanges(layout);
  const std::string no_text = whyNoText(path);
  if (!no_text.empty()) log->note(path + " " + no_text);
  if (!why_not.empty()) log->note(path + ": " + why_not);
  if (why_not.empty() && !wide && !c.named) {
    sayByPosition(path, layout, {{c.stamp, "stamp"}, {c.anchor, "anchor"}, {c.range, "range"}},
                  false, log);
  }
  // Several anchors may answer at one time, and to several antennas.
  const auto same = [](const RangeRow& a, const RangeRow& b) {
    return a.anchor == b.anchor && a.reference == b.reference && a.antenna == b.antenna &&
           a.place == b.place;
  };
  RowCursor<RangeRow>::Spec spec{path,  between_anchors ? "anchor_range" : "range", {}, same, false,
                                 layout};
  if (!why_not.empty()) {
    spec.parse = [](const Fields&, RangeRow*, RowFault* fault) {
      *fault = {"no_range", ""};
      return false;
    };
  } else if (!wide) {
    spec.parse = [table](const Fields& f, RangeRow* row, RowFault* fault) {
      return table.between_anchors ? parseBetween(f, table, row, fault)
                                   : parseRange(f, table, row, fault);
    };
  }
  for (std::size_t i = 0; i < c.wide.size() && why_not.empty(); ++i) {
    auto parse = [table, i](const Fields& f, RangeRow* row, RowFault* fault) {
      return parseOneOf(f, table, table.c.wide[i], row, fault);
    };
    if (i == 0) {
      spec.parse = parse;
    } else {
      spec.also.emplace_back(parse);
    }
  }
  return std::make_unique<RowCursor<RangeRow>>(std::move(spec), log);
}

}  // namespace

std::unique_ptr<RowStream<RangeRow>> openRanges(const std::string& path, const Units& units,
                                                tables::AnchorNames* names, ProblemLog* log) {
  return open(path, units, names, log, false);
}

std::unique_ptr<RowStream<RangeRow>> openAnchorRanges(const std::string& path, const Units& units,
                                                      tables::AnchorNames* names, ProblemLog* log) {
  const tables::RangeColumns c = tables::rangeColumns(tables::layoutOf(path));
  if (!c.named || c.antenna < 0) {
    throw InputError(path +
                     ": of ranges between anchors a header has to name both ends and the range, as "
                     "in `t,from,to,range`");
  }
  return open(path, units, names, log, true);
}

std::vector<std::string> antennasIn(const std::string& path) {
  const tables::Layout layout = tables::layoutOf(path);
  const int column = tables::rangeColumns(layout).antenna;
  std::set<std::string> names;
  for (const auto* rows : {&layout.rows, &layout.later}) {
    for (const auto& row : *rows) {
      const auto c = static_cast<std::size_t>(column);
      if (column >= 0 && c < row.size() && !row[c].empty()) names.insert(row[c]);
    }
  }
  return {names.begin(), names.end()};
}

}  // namespace vir::euroc
