#include "range_layouts.h"

#include <cctype>
#include <optional>
#include <set>
#include <string_view>

#include "units.h"
#include "vir/core/parse_number.h"

namespace vir::tables {
namespace {

constexpr double kLight = 299'702'547.0;  // m/s, in air
/// Above this a column is no range of a radio [m].
constexpr double kLongest = 2000;

/// [s]; of `ps` too, in which radios count.
std::optional<double> secondsOf(std::string_view unit) {
  if (unit == "ps") return 1e-12;
  const auto known = stampUnitOfText(unit);
  if (!known) return std::nullopt;
  switch (*known) {
    case StampUnit::seconds:
      return 1.0;
    case StampUnit::milliseconds:
      return 1e-3;
    case StampUnit::microseconds:
      return 1e-6;
    case StampUnit::nanoseconds:
      return 1e-9;
  }
  return std::nullopt;
}

bool hasDigit(std::string_view text) {
  for (const char c : text) {
    if (std::isdigit(static_cast<unsigned char>(c)) != 0) return true;
  }
  return false;
}

/// `range_north`, `distance_to_door`, but not `range_std`.
bool mayBeAnchor(std::string_view front, std::string_view rest) {
  if (rest.size() < 2) return front.size() > 4 && front.substr(front.size() - 4) == "_to_";
  for (const std::string_view word :
       {"std",    "sigma",  "noise",      "error", "err",      "raw",     "true",
        "gt",     "truth",  "est",        "meas",  "measured", "valid",   "unit",
        "type",   "rate",   "mean",       "bias",  "rssi",     "quality", "id",
        "stddev", "var",    "covariance", "min",   "max",      "diff",    "residual",
        "mm",     "cm",     "km",         "ft",    "in",       "yd",      "time",
        "stamp",  "status", "count",      "max_m", "min_m",    "std_dev"}) {
    if (rest == word) return false;
  }
  return front == "distance_to_" || front == "dist_to_" || front == "range_to_" ||
         front == "range_";
}

/// What a column of ranges to one anchor calls the anchor, in a plain name without unit; empty: it
/// is called otherwise. `sure`: a range is named, not an anchor alone.
std::string_view anchorIn(std::string_view name, bool* sure) {
  *sure = true;
  for (const std::string_view front :
       {"distance_to_", "distance_", "dist_to_", "dist_", "range_to_", "ranges_", "range_", "d_"}) {
    if (name.substr(0, front.size()) == front) {
      const std::string_view rest = name.substr(front.size());
      *sure = hasDigit(rest);
      return *sure || mayBeAnchor(front, rest) ? rest : std::string_view();
    }
  }
  const auto numbered = [&](std::string_view front) {
    return name.size() > front.size() && name.substr(0, front.size()) == front &&
           name.find_first_not_of("0123456789", front.size()) == name.npos;
  };
  for (const std::string_view front : {"distance", "dist", "range", "d"}) {
    if (numbered(front)) return name.substr(front.size());
  }
  *sure = false;
  for (const std::string_view front : {"anchor_", "anchor", "anc_", "anc", "beacon_", "beacon"}) {
    if (numbered(front)) return name.substr(front.size());
  }
  return numbered("a") ? name : std::string_view();
}

/// Most values are numbers or missing, and some are ranges, if only later: an anchor may be out of
/// reach at first.
bool holdsRanges(const Layout& layout, int column) {
  long good = 0, bad = 0;
  for (const auto* rows : {&layout.rows, &layout.later}) {
    for (const auto& row : *rows) {
      const auto c = static_cast<std::size_t>(column);
      double v = 0;
      if (c >= row.size()) continue;
      if (parseFinite(row[c], &v)) {
        (v < kLongest * 1000 ? good : bad) += 1;
      } else if (!row[c].empty() && !parseNumber(row[c], &v)) {
        ++bad;
      }
    }
  }
  return good > 0 && bad * 10 <= good;
}

}  // namespace

std::size_t differentValues(const Layout& layout, int column) {
  std::set<std::string> values;
  for (const auto* rows : {&layout.rows, &layout.later}) {
    for (const auto& row : *rows) {
      const auto c = static_cast<std::size_t>(column);
      if (column >= 0 && c < row.size()) values.insert(row[c]);
    }
  }
  return values.size();
}

bool findEnds(const Layout& layout, int anchor, RangeColumns* out) {
  const int from = layout.find({"src", "source", "from", "src_id", "source_id", "from_id"});
  const int to = layout.find(
      {"dst", "dest", "destination", "to", "dst_id", "dest_id", "destination_id", "to_id"});
  if (from < 0 || to < 0 || (anchor >= 0 && anchor != from && anchor != to)) return false;
  const bool turned = differentValues(layout, from) > differentValues(layout, to);
  out->anchor = turned ? from : to;
  out->antenna = turned ? to : from;
  const auto name = [&](int c) { return layout.names[static_cast<std::size_t>(c)]; };
  out->remarks.push_back("the anchors are in column " + name(out->anchor) +
                         ", the robot's antennas in column " + name(out->antenna) +
                         (turned ? ", which has fewer values" : ""));
  return true;
}

bool findDifference(const Layout& layout, RangeColumns* out) {
  const int difference = layout.find({"tdoa", "tdoa_m", "tdoa_meas", "tdoa_measurement",
                                      "range_difference", "range_diff", "difference",
                                      "difference_m", "distance_difference", "distance_diff"});
  const int reference =
      layout.find({"reference", "reference_id", "reference_anchor", "ref", "ref_id", "ida", "id_a",
                   "anchor_a", "anchora", "from", "from_id"});
  const int anchor = layout.find(
      {"anchor", "anchor_id", "idb", "id_b", "anchor_b", "anchorb", "to", "to_id", "id"});
  if (difference < 0 || reference < 0 || anchor < 0) return false;
  out->range = difference;
  out->reference = reference;
  out->anchor = anchor;
  const auto name = [&](int c) { return layout.names[static_cast<std::size_t>(c)]; };
  out->remarks.push_back("differences of ranges (TDoA): column " + name(difference) +
                         " is taken for the range to the anchor in column " + name(anchor) +
                         " less that to the one in column " + name(reference));
  return true;
}

bool findFlightTime(const Layout& layout, RangeColumns* out) {
  for (std::size_t i = 0; i < layout.names.size(); ++i) {
    for (const std::string base : {"tof", "time_of_flight", "flight_time"}) {
      const std::string& name = layout.names[i];
      const bool plain = name == base;
      if (!plain && name.compare(0, base.size() + 1, base + "_") != 0) continue;
      const auto unit = secondsOf(plain ? layout.units[i] : name.substr(base.size() + 1));
      if (!plain && !unit) continue;
      if (!unit) {
        out->refusal = "its column " + name +
                       " is a time of flight without a unit: write its unit behind the name, as "
                       "in `tof [ns]`, or metres, as in `range [m]`";
        return true;
      }
      out->range = static_cast<int>(i);
      out->unit_m = kLight * *unit;
      out->remarks.push_back("column " + name +
                             " is taken for times of flight one way (halve them if they are of the "
                             "way there and back)");
      return true;
    }
  }
  return false;
}

void findWide(const Layout& layout, RangeColumns* out) {
  double unit_m = 0;
  std::size_t sure_ones = 0;
  std::vector<AnchorColumn> found;
  for (std::size_t i = 0; i < layout.names.size(); ++i) {
    const int column = static_cast<int>(i);
    const std::string &plain = layout.names[i], &bare = layout.bare[i];
    bool sure = false;
    const std::string anchor(anchorIn(bare, &sure));
    if (anchor.empty() || column == out->stamp || !holdsRanges(layout, column)) continue;
    sure_ones += sure ? 1 : 0;
    const Unit unit = unitAt(layout, column);
    const bool named = unit.quantity == Quantity::length;
    if (named && unit_m == 0) unit_m = unit.factor;
    // As written, where it is as long: letters are lower in plain names.
    const std::string& written = layout.written[i];
    const std::size_t at = plain.find(bare) + bare.size() - anchor.size();
    found.push_back({written.size() == plain.size() ? written.substr(at, anchor.size()) : anchor,
                     column, named ? unit.factor : 0});
  }
  if (found.size() < 2 && sure_ones == 0) return;
  for (AnchorColumn& a : found) {
    if (a.unit_m == 0) a.unit_m = unit_m > 0 ? unit_m : 1;
  }
  out->wide = std::move(found);
  std::string names;
  for (const AnchorColumn& a : out->wide) names += (names.empty() ? "" : ", ") + a.anchor;
  out->remarks.push_back("a column of ranges for each anchor, to " + names.substr(0, 200) +
                         "; empty ones, nan and what is not above 0 are no measurements");
}

}  // namespace vir::tables
