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
  /// "line 12: expected 8 numbers, found 5", for the first lines that were skipped (at most 20).
  std::vector<std::string> messages;

  long skipped() const { return malformed + not_finite + zero_quaternions + repeated; }
};

/// Decimal seconds (with or without exponent) to nanoseconds without passing through a double;
/// digits beyond the ninth decimal are rounded. False for anything else, and for values that do not
/// fit (seconds of more than about 292 years).
bool parseSeconds(const std::string& text, TimeNs* t);

/// Seconds with 9 decimals, exact.
std::string formatSeconds(TimeNs t);

/// TUM: `t x y z qx qy qz qw`, seconds and metres, separated by blanks; `#` starts a comment.
Trajectory readTum(std::istream& in, ReadReport* report);

/// EuRoC ground truth: `t,x,y,z,qw,qx,qy,qz[,...]`, nanoseconds and metres; further columns are
/// ignored; `#` starts a comment.
Trajectory readEurocGroundTruth(std::istream& in, ReadReport* report);

/// Either of the two: EuRoC if the first line that is no comment has a comma.
Trajectory readTrajectory(std::istream& in, ReadReport* report);

/// First column of a csv in nanoseconds (EuRoC's cam0/data.csv), ascending; other lines (a header,
/// comments, lines without a number in front) are skipped.
std::vector<TimeNs> readStamps(std::istream& in);

/// One TUM line without line break, 9 decimals.
std::string tumLine(const StampedPose& pose);

/// All poses, one per line. The caller checks the stream.
void writeTum(std::ostream& out, const Trajectory& trajectory);

}  // namespace vir::evaluation
