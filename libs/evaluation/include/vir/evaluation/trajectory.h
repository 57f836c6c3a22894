#pragma once
/// Trajectories (types/state.h) and their text formats. Readers never throw on bad content: a line
/// that cannot be used is skipped, counted and described with its line number.
#include <iosfwd>
#include <string>
#include <vector>

#include "vir/core/time.h"
#include "vir/geometry/pose.h"
#include "vir/types/state.h"

namespace vir::evaluation {

/// What a reader found besides good poses.
struct ReadReport {
  long poses = 0;                   ///< poses returned
  long malformed = 0;               ///< lines skipped: not the expected numbers
  long not_finite = 0;              ///< lines skipped: NaN or infinity
  long zero_quaternions = 0;        ///< lines skipped: a quaternion of length 0 is no attitude
  long quaternions_normalised = 0;  ///< used; the length was off by more than 1e-3
  long out_of_order = 0;            ///< used; the stamp was before that of an earlier line
  long repeated = 0;                ///< lines skipped: the stamp was there already (first wins)
  bool positions_only = false;      ///< no attitudes in the file: all are the identity
  /// One for each kind of fault, with the first line that has it and how many more there are:
  /// "line 12: expected 8 numbers, found 5 fields (and 3 more like this)".
  std::vector<std::string> messages;
  /// What was not as in a TUM or EuRoC file and was understood: "the stamps are in ms".
  std::vector<std::string> notes;

  long skipped() const { return malformed + not_finite + zero_quaternions + repeated; }
};

/// Decimal seconds (with or without exponent) to nanoseconds without passing through a double;
/// digits beyond the ninth decimal are rounded. False for anything else, and for values that do not
/// fit (seconds of more than about 292 years).
bool parseSeconds(const std::string& text, TimeNs* t);

/// Seconds with 9 decimals, exact.
std::string formatSeconds(TimeNs t);

/// TUM: `t x y z qx qy qz qw`, seconds and metres, separated by blanks; `#` starts a comment. Poses
/// before a frameChangeLine() are given in the frame of those behind it.
Trajectory readTum(std::istream& in, ReadReport* report);

/// Any table of poses (vir/tables/layout.h): columns by the names of a header, else TUM's where
/// there are blanks or seconds and EuRoC's elsewhere, which a note says; stamps in the unit that
/// they can only be in; positions alone.
Trajectory readTrajectory(std::istream& in, ReadReport* report);

/// First column of a csv in nanoseconds (EuRoC's cam0/data.csv), ascending; other lines (a header,
/// comments, lines without a number in front) are skipped.
std::vector<TimeNs> readStamps(std::istream& in);

/// One TUM line without line break, 9 decimals.
std::string tumLine(const StampedPose& pose);

/// A comment, for other readers, which says that the poses before it are of another frame, and how
/// that lies in the frame of those behind it. Without line break.
std::string frameChangeLine(const Pose& T_new_old);

/// All poses, one per line. The caller checks the stream.
void writeTum(std::ostream& out, const Trajectory& trajectory);

}  // namespace vir::evaluation
