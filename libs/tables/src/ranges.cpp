#include "vir/tables/ranges.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

#include "axes.h"
#include "range_layouts.h"
#include "units.h"
#include "vir/core/order_statistics.h"
#include "vir/core/parse_number.h"

namespace vir::tables {
namespace {

/// An antenna is nearer to the middle of its robot, which has no more of them.
constexpr double kFarthestAntenna = 10;  // m
constexpr std::size_t kMostPlaces = 8;
constexpr double kLeastSigma = 5e-4, kMostSigma = 3;  // m

/// By plain name, or by that without its unit.
int findBare(const Layout& layout, const std::vector<std::string>& wanted) {
  const int whole = layout.find(wanted);
  if (whole >= 0) return whole;
  for (std::size_t i = 0; i < layout.names.size(); ++i) {
    if (std::count(wanted.begin(), wanted.end(), layout.bare[i]) > 0) {
      return static_cast<int>(i);
    }
  }
  return -1;
}

std::string nameAt(const Layout& layout, int column) {
  return layout.names[static_cast<std::size_t>(column)];
}

std::string shortNumber(double v) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", v);
  return text;
}

/// Where the antenna is on the robot.
void findLever(const Layout& layout, RangeColumns* out) {
  int found[3];
  const bool there = findAxes(layout,
                              {"antenna_", "antenna_position_", "antenna_pos_", "ant_", "lever_",
                               "lever_arm_", "tag_", "tag_position_", "tag_pos_", "offset_"},
                              {"x", "y", "z"}, found);
  if (!there) return;
  const double unit_m = lengthUnit(layout, found[0]);
  std::set<std::string> places;
  double farthest = 0;
  for (const auto* rows : {&layout.rows, &layout.later}) {
    for (const auto& row : *rows) {
      std::string place;
      double squared = 0;
      for (const int column : found) {
        const auto c = static_cast<std::size_t>(column);
        double v = 0;
        if (c >= row.size() || !parseFinite(row[c], &v)) continue;
        squared += v * v;
        place += row[c] + " ";
      }
      places.insert(place);
      farthest = std::max(farthest, std::sqrt(squared) * unit_m);
    }
  }
  const std::string what =
      nameAt(layout, found[0]) + ", " + nameAt(layout, found[1]) + ", " + nameAt(layout, found[2]);
  if (places.size() > kMostPlaces || farthest > kFarthestAntenna) {
    out->remarks.push_back("its columns " + what +
                           " are not used: an antenna on a robot has a place that stays, within " +
                           shortNumber(kFarthestAntenna) + " m");
    return;
  }
  std::copy(found, found + 3, out->lever);
  out->lever_unit_m = unit_m;
  out->remarks.push_back("the antennas are where its columns " + what +
                         " say, in the IMU's axes, at most " + shortNumber(farthest) +
                         " m from it");
}

/// Where the anchor is. In a table with a column for each of them there is no row for one.
void findPlace(const Layout& layout, RangeColumns* out) {
  int found[3];
  const bool there = out->wide.empty() &&
                     findAxes(layout,
                              {"anchor_", "anchor_position_", "anchor_pos_", "anchor_location_",
                               "beacon_", "beacon_position_", "beacon_pos_", "responder_location_",
                               "responder_position_", "responder_"},
                              {"x", "y", "z"}, found);
  if (!there) return;
  std::copy(found, found + 3, out->place);
  out->place_unit_m = lengthUnit(layout, found[0]);
}

void findSigma(const Layout& layout, RangeColumns* out) {
  const int column = findBare(layout, {"std", "sigma", "noise", "stddev", "std_dev", "stdev",
                                       "range_std", "range_sigma", "range_noise", "range_stddev",
                                       "std_error", "stderr", "standard_deviation", "uncertainty"});
  if (column < 0) return;
  const Unit unit = unitAt(layout, column);
  const double unit_m = unit.quantity == Quantity::length ? unit.factor : out->unit_m;
  std::vector<double> sizes;
  for (const std::string& text : layout.column(static_cast<std::size_t>(column))) {
    double v = 0;
    if (parseFinite(text, &v) && v > 0) sizes.push_back(v * unit_m);
  }
  const double middle = medianInPlace(&sizes);
  const bool other = unit.quantity != Quantity::length && unit.quantity != Quantity::none;
  if (other || middle < kLeastSigma || middle > kMostSigma) {
    out->remarks.push_back("its column " + nameAt(layout, column) +
                           " is not used: it would be a standard deviation of " +
                           shortNumber(middle) + " m; name its unit, as in `std [m]`");
    return;
  }
  out->sigma = column;
  out->sigma_unit_m = unit_m;
  out->remarks.push_back("the noise of each range is taken from its column " +
                         nameAt(layout, column) + ", " + shortNumber(middle) + " m in the middle");
}

void findFlags(const Layout& layout, RangeColumns* out) {
  out->valid = layout.find({"valid", "is_valid", "range_valid", "valid_range", "validity"});
  out->nlos = layout.find({"nlos", "is_nlos", "nlos_flag", "non_line_of_sight"});
  out->los = layout.find({"los", "is_los", "los_flag", "line_of_sight"});
  if (out->valid >= 0) {
    out->remarks.push_back("rows whose column " + nameAt(layout, out->valid) +
                           " is 0 or false are left out and counted");
  }
}

/// Columns that nobody reads, once.
void sayUnused(const Layout& layout, RangeColumns* out) {
  std::set<int> used{
      out->stamp, out->antenna, out->reference, out->sigma,
      out->valid, out->nlos,    out->los,       nanosecondColumn(layout, out->stamp)};
  used.insert(out->lever, out->lever + 3);
  used.insert(out->place, out->place + 3);
  if (out->wide.empty()) used.insert({out->anchor, out->range});
  for (const AnchorColumn& a : out->wide) used.insert(a.column);
  std::string unused;
  for (std::size_t i = 0; i < layout.names.size(); ++i) {
    const std::string& name = layout.names[i];
    const bool counts = name == "seq" || name == "index" || name == "count" || name == "no" ||
                        name == "header_seq" || name == "frame_id" || name == "header_frame_id";
    const bool time = name.find("time") != name.npos || name.find("stamp") != name.npos;
    const bool truth = name.compare(0, 5, "true_") == 0;  // of a simulation
    if (name.empty() || counts || time || truth || used.count(static_cast<int>(i)) > 0) continue;
    unused += (unused.empty() ? "" : ", ") + name;
  }
  if (!unused.empty())
    out->remarks.push_back("columns that are not used: " + unused.substr(0, 200));
}

/// Of columns whose names are not known: the range is the one whose unit is a length.
void findLength(const Layout& layout, RangeColumns* out) {
  std::vector<int> lengths;
  for (int i = 0; i < static_cast<int>(layout.names.size()); ++i) {
    if (unitAt(layout, i).quantity == Quantity::length) lengths.push_back(i);
  }
  if (lengths.size() == 1 && lengths.front() == out->anchor) std::swap(out->anchor, out->range);
  out->unit_m = lengthUnit(layout, out->range);
}

}  // namespace

int RangeColumns::last() const {
  int out = std::max({stamp, antenna, valid, lever[0], lever[1], lever[2]});
  // A row of a wide table may end early.
  if (wide.empty()) out = std::max({out, anchor, range, reference});
  return out;
}

RangeColumns rangeColumns(const Layout& layout) {
  RangeColumns out;
  out.stamp = stampColumn(layout);
  int anchor = layout.find({"anchor_id",    "anchor",    "id",      "anchorid", "anchor_name",
                            "responder_id", "responder", "to_id",   "node_id",  "tag_id",
                            "dest_id",      "source_id", "dest",    "node",     "beacon_id",
                            "beacon",       "device",    "address", "addr",     "anc_id"});
  int range = layout.find({"range",
                           "distance",
                           "dist",
                           "range_m",
                           "distance_m",
                           "r",
                           "d",
                           "dist_m",
                           "range_mm",
                           "dist_mm",
                           "distance_mm",
                           "range_cm",
                           "distance_cm",
                           "measurement",
                           "tof_m",
                           "meas",
                           "value",
                           "range_meas",
                           "distance_est",
                           "range_raw",
                           "dist_cm",
                           "measured_range",
                           "measured_range_m",
                           "measured_distance",
                           "measured_distance_m"});
  const bool differs = range < 0 && findDifference(layout, &out);
  if (differs) {
    range = out.range;
    anchor = out.anchor;
  }
  const bool by_flight = range < 0 && findFlightTime(layout, &out);
  if (by_flight && out.refusal.empty()) range = out.range;
  out.flight = by_flight && range >= 0;
  const bool by_ends = range >= 0 && !differs && findEnds(layout, anchor, &out);
  if (by_ends) anchor = out.anchor;
  out.named = anchor >= 0 && range >= 0;
  out.anchor = out.named ? anchor : out.stamp + 1;
  out.range = out.named ? range : out.stamp + 2;
  if (!by_ends) out.antenna = layout.find({"antenna", "antenna_id", "ant", "rx_antenna"});
  if (out.antenna < 0) {  // the robot's own radios
    const int tag = layout.find({"tag", "tag_id", "tag_name", "initiator", "initiator_id"});
    if (tag != out.anchor) out.antenna = tag;
  }
  if (out.named && !by_flight) out.unit_m = lengthUnit(layout, out.range);
  if (!out.named && namesAll(layout)) findWide(layout, &out);
  if (!out.named && out.wide.empty()) {
    findLength(layout, &out);
    return out;
  }
  findLever(layout, &out);
  findPlace(layout, &out);
  findSigma(layout, &out);
  findFlags(layout, &out);
  sayUnused(layout, &out);
  return out;
}

}  // namespace vir::tables
