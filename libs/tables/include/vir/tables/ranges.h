#pragma once
/// Columns of tables of ranges.
#include <string>
#include <vector>

#include "vir/tables/layout.h"

namespace vir::tables {

/// One column of ranges to one anchor.
struct AnchorColumn {
  std::string anchor;  ///< as written in the header: `0x84` of `d_0x84 [m]`
  int column = 0;
  double unit_m = 1;
};

/// Where a row has what; -1: not there.
struct RangeColumns {
  int stamp = 0, anchor = 1, range = 2;
  int antenna = -1;  ///< which of the robot's own antennas
  /// Set: differences of ranges (TDoA), `range` being that to `anchor` less that to this one.
  int reference = -1;
  bool named = false;
  double unit_m = 1;               ///< of what the header says the ranges are in
  bool flight = false;             ///< those are times of flight, which range_unit does not change
  int lever[3] = {-1, -1, -1};     ///< where the antenna is on the robot, x y z
  double lever_unit_m = 1;         ///< of those
  int place[3] = {-1, -1, -1};     ///< where the anchor is, in a frame of its own, x y z
  double place_unit_m = 1;         ///< of those
  int sigma = -1;                  ///< standard deviation of the range
  double sigma_unit_m = 1;         ///< of that
  int valid = -1;                  ///< false: no measurement
  int nlos = -1, los = -1;         ///< was the line of sight blocked, or was it free
  std::vector<AnchorColumn> wide;  ///< a column for each anchor; then there is no `anchor`, `range`
  std::vector<std::string> remarks;  ///< what is to be said of the columns
  std::string refusal;               ///< why the ranges cannot be used, and what to do; else empty
  bool hasLever() const { return lever[0] >= 0; }
  bool hasPlace() const { return place[0] >= 0; }
  int last() const;  ///< the last column that every row must have
};
/// By the names of the header, else t, anchor, range. `src`, `dst`: the anchor is in the one that
/// has more values. Columns of an antenna's place are those only where they hold a few places near
/// the robot, a noise only where it is of a plausible size.
RangeColumns rangeColumns(const Layout& layout);
/// Why a table of ranges holds none that can be used: a header that names only one of the two, or
/// neither, or times of flight without a unit; else empty.
std::string whyNoRanges(const Layout& layout);

}  // namespace vir::tables
