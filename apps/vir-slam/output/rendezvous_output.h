#pragma once
/// What `vir-slam rendezvous` writes.
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "robots/pair_rendezvous.h"
#include "robots/robot_record.h"
#include "vir/evaluation/figure.h"
#include "vir/results/results_folder.h"

namespace vir::app {

/// Everything that is tied together, in the world of `root`.
struct MergedMap {
  std::string root;
  std::map<std::string, team::WorldTransform> T_root;  ///< from each tied robot's world
  std::map<std::string, Trajectory> trajectories;      ///< in the root's world
};

/// How well robot B lies in A's world, where both have ground truth.
struct MergeError {
  std::string from, to;
  double merged_rmse_m = 0;      ///< of B's trajectory as written, A's laid onto its truth
  double own_merged_rmse_m = 0;  ///< the same with what each estimated alone and the transform
  double offset_error_m = 0, yaw_error_deg = 0;
};

std::optional<MergeError> mergeError(const RobotRecord& a, const RobotRecord& b,
                                     const team::WorldTransform& T_A_B, const MergedMap& map);

void writeMergedTrajectories(const results::ResultsFolder& folder, const MergedMap& map);
void writeMergedLandmarks(const results::ResultsFolder& folder, const MergedMap& map,
                          const std::vector<RobotRecord>& robots);
void writeHistory(const results::ResultsFolder& folder, const std::vector<PairResult>& pairs);

/// scene.3Dscene: all robots merged, and below, side by side, each one in its own world.
void writeRendezvousScene(const results::ResultsFolder& folder, const MergedMap& map,
                          const std::vector<RobotRecord>& robots);

/// Each robot in its own world below, all in the root's above.
evaluation::Figure rendezvousFigure(const MergedMap& map, const std::vector<RobotRecord>& robots);

}  // namespace vir::app
