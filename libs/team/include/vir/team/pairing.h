#pragma once
/// Two robots that met: their mutual ranges, played to a solver as they came in.
#include <optional>
#include <vector>

#include "vir/team/pair_solver.h"
#include "vir/team/pair_transform.h"
#include "vir/team/robot_record.h"

namespace vir::team {

/// Standard deviation [m], per axis, of where an antenna is on a robot whose recording does not
/// say.
constexpr double kUnknownAntennaSigma = 0.1;

/// A mutual range with both robots' states; A is the robot that is named first.
struct MutualObservation {
  MutualRange range;
  int segment_A = 0, segment_B = 0;
  Vec3 antenna_A = Vec3::Zero(), antenna_B = Vec3::Zero();  ///< on the robots [m]
  bool antenna_unknown = false;  ///< one of them; the covariances hold kUnknownAntennaSigma
};

struct MutualRanges {
  std::vector<MutualObservation> list;  ///< in order of time
  long without_state = 0;               ///< one of the two had no pose then: not used
  long doubled = 0;                     ///< in both recordings, used once
  long antenna_unknown = 0;             ///< of those in `list`
};

/// From both recordings, with each robot's own causal estimate at the range's time: its paths and
/// maps are to be tied together, so that what it once broadcast of another estimate is of no use. A
/// range found in both recordings counts once. The antenna of the robot that answered is where its
/// own recording says; where that says nothing, the body's origin, with a wider covariance.
MutualRanges mutualRanges(const RobotRecord& a, const RobotRecord& b);

/// Anchors that both believed in at `t`.
std::vector<SharedAnchor> sharedAnchors(const RobotRecord& a, const RobotRecord& b, TimeNs t);

/// The answer at one time.
struct PairMoment {
  double since_first_s = 0;
  TransformAnswer answer;
};

struct PairResult {
  PairTransform transform;  ///< p_A = T p_B
  std::vector<PairMoment> history;
  MutualRanges ranges;
  std::optional<SharedPlaces> places = {};  ///< that both have seen
};

struct PairOptions {
  double interval_s = 0.5;  ///< between two answers
  bool use_anchors = true;  ///< those that both robots know
};

/// Asks `solver` every `interval_s`, and at the last range. `places` are told once the first of
/// them had been seen by both.
PairResult playPair(const RobotRecord& a, const RobotRecord& b, PairSolver* solver,
                    const PairOptions& options, const std::optional<SharedPlaces>& places = {});

}  // namespace vir::team
