/// Why a table holds nothing of a kind.
#include <algorithm>
#include <cmath>

#include "vir/core/parse_number.h"
#include "vir/tables/layout.h"
#include "vir/tables/ranges.h"

namespace vir::tables {

bool namesAll(const Layout& layout) {
  const auto named = static_cast<std::size_t>(
      std::count_if(layout.names.begin(), layout.names.end(),
                    [](const std::string& name) { return !name.empty(); }));
  if (named < layout.columns) return false;
  return namedStampColumn(layout) >= 0;
}

namespace {

std::string namesOf(const Layout& layout) {
  std::string out;
  for (const std::string& name : layout.names) out += (out.empty() ? "" : ", ") + name;
  return out.substr(0, 200);
}

}  // namespace

std::string whyNoPoses(const Layout& layout) {
  if (layout.find({"latitude", "lat"}) >= 0 &&
      layout.find({"longitude", "lon", "lng", "long"}) >= 0 && !poseColumns(layout).named) {
    return "its positions are latitude and longitude in degrees: convert them to metres (UTM, or "
           "axes of the place)";
  }
  if (namesAll(layout) && !poseColumns(layout).named) {
    return "its header names no x, y and z of a position, it has: " + namesOf(layout);
  }
  if (layout.columns != 12 || !layout.names.empty()) return {};
  for (const auto& row : layout.rows) {
    for (const std::size_t c : {0u, 1u, 2u, 4u, 5u, 6u, 8u, 9u, 10u}) {
      double v = 0;
      if (c >= row.size() || !parseNumber(row[c], &v) || !(std::abs(v) < 1.001)) return {};
    }
  }
  return "its lines are 12 numbers without a stamp, KITTI's poses: write t x y z qx qy qz qw";
}

std::string whyNoRanges(const Layout& layout) {
  const RangeColumns c = rangeColumns(layout);
  if (!c.refusal.empty()) return c.refusal;
  if (!namesAll(layout) || c.named || !c.wide.empty()) return {};
  return "its header names no anchor (anchor_id) or no range (range_m), nor a column for each "
         "anchor (d_1, d_2, ... or range_NORTH, range_DOOR, ...), it has: " +
         namesOf(layout);
}

}  // namespace vir::tables
