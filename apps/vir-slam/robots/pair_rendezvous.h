#pragma once
/// Two robots that met: their mutual ranges, played to a rendezvous plugin as they came in.
#include <string>
#include <vector>

#include "robots/robot_record.h"
#include "vir/results/transforms_json.h"
#include "vir/roles/rendezvous.h"

namespace vir::app {

/// A mutual range with both robots' states; A is the robot that is named first.
struct MutualObservation {
  team::MutualRange range;
  int segment_A = 0, segment_B = 0;
};

struct MutualRanges {
  std::vector<MutualObservation> list;  ///< in order of time
  long without_state = 0;               ///< one of the two had no pose then: not used
  long doubled = 0;                     ///< in both recordings, used once
};

/// From both recordings, with each robot's own causal estimate at the range's time: its paths and
/// maps are to be tied together, so that what it once broadcast of another estimate is of no use. A
/// range found in both recordings counts once.
MutualRanges mutualRanges(const RobotRecord& a, const RobotRecord& b);

/// Anchors that both believed in at `t`.
std::vector<team::SharedAnchor> sharedAnchors(const RobotRecord& a, const RobotRecord& b, TimeNs t);

/// The answer at one time.
struct PairMoment {
  double since_first_s = 0;
  team::TransformAnswer answer;
};

struct PairResult {
  team::PairTransform transform;  ///< p_A = T p_B
  std::vector<PairMoment> history;
  MutualRanges ranges;
};

PairResult playPair(const RobotRecord& a, const RobotRecord& b, roles::Rendezvous* solver,
                    double interval_s, bool use_anchors);

}  // namespace vir::app
