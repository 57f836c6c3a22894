#pragma once
/// Robots whose recordings are at hand: pair by pair, around loops, and all together.
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "vir/core/log.h"
#include "vir/team/joint_solution.h"
#include "vir/team/merged_map.h"
#include "vir/team/peer_tracker.h"

namespace vir::team {

struct MeetingOptions {
  double interval_s = 0.5;  ///< between two answers of a pair
  bool use_anchors = true;  ///< those that both robots of a pair know
  bool solve_jointly = true;
  JointOptions joint;
};

struct Meeting {
  std::vector<RobotRecord> robots;
  std::vector<PairResult> pairs;
  MergedMap map;
};

/// What the images of two robots have in common, by (name of A, name of B), A named first.
using PlacesOfPairs = std::map<std::pair<std::string, std::string>, SharedPlaces>;

/// Names and ids of `robots` must differ. What could not be used, and loops that do not close, are
/// told to `log`.
Meeting meet(std::vector<RobotRecord> robots, const MeetingOptions& options,
             const PairSolverFactory& create_solver, const LogSink& log,
             const PlacesOfPairs& places = {});

}  // namespace vir::team
