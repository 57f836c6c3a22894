#pragma once
/// Ranges of recordings together with the true distances, for calibration.
#include <map>
#include <string>
#include <vector>

#include "vir/geometry/pose.h"
#include "vir/ranging/range_calibration.h"
#include "vir/ranging/range_check.h"

namespace vir::app {

using AnchorPositions = std::map<int, Vec3>;

/// `ID,X,Y,Z`; throws UsageError for anything else or an id that is there already.
void addAnchor(const std::string& text, AnchorPositions* anchors);

/// csv: id,x,y,z and further columns that are ignored; `#` starts a comment, a header is allowed.
/// Throws UsageError with file and line.
void addAnchorFile(const std::string& path, AnchorPositions* anchors);

/// A range with the antenna's true position.
struct TrueRange {
  TimeNs t = 0;
  int anchor = 0, series = 0;
  Vec3 antenna = Vec3::Zero();
  double range_m = 0;
};

struct UwbSamples {
  std::vector<TrueRange> seen;  ///< from which the samples are made
  std::vector<ranging::CalibrationSample> samples;
  std::vector<int> anchor;  ///< of each sample
  long ranges = 0;          ///< read in all
  ranging::RangeCheckCounters checks;
  long without_truth = 0;              ///< no ground truth at their time
  std::map<int, long> unknown_anchor;  ///< ranges per id without a position that could be found
  std::vector<std::string> damage;     ///< of recordings cut off
  std::vector<std::string> notes;      ///< ground truth that was left out
};

/// Reads ground truth (label GT) and anchor ranges of a recording and adds them to `seen`. Throws
/// std::runtime_error if the file cannot be read or holds no ground truth or no ranges.
void addRecording(const std::string& rawlog, UwbSamples* out);

/// The samples of all that was seen. An anchor whose position is not given is looked for in its own
/// ranges, which is said in the notes. Throws std::runtime_error where a given position is not
/// where the ranges put the anchor.
void fillSamples(AnchorPositions anchors, UwbSamples* out);

}  // namespace vir::app
