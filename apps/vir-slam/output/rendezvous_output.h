#pragma once
/// What `vir-slam rendezvous` writes.
#include <optional>
#include <string>
#include <vector>

#include "vir/evaluation/figure.h"
#include "vir/results/results_folder.h"
#include "vir/team/merged_map.h"

namespace vir::app {

/// How well robot B lies in A's world, where both have ground truth.
struct MergeError {
  std::string from, to;
  double merged_rmse_m = 0;      ///< of B's trajectory as written, A's laid onto its truth
  double own_merged_rmse_m = 0;  ///< the same with what each estimated alone and the transform
  double offset_error_m = 0, yaw_error_deg = 0;
};

std::optional<MergeError> mergeError(const team::RobotRecord& a, const team::RobotRecord& b,
                                     const team::WorldTransform& T_A_B, const team::MergedMap& map);

void writeMergedTrajectories(const results::ResultsFolder& folder, const team::MergedMap& map);
void writeMergedLandmarks(const results::ResultsFolder& folder, const team::MergedMap& map,
                          const std::vector<team::RobotRecord>& robots);
void writeHistory(const results::ResultsFolder& folder, const std::vector<team::PairResult>& pairs);

/// scene.3Dscene: all robots merged, and below, side by side, each one in its own world.
void writeRendezvousScene(const results::ResultsFolder& folder, const team::MergedMap& map,
                          const std::vector<team::RobotRecord>& robots);

/// Each robot in its own world below, all in the root's above.
evaluation::Figure rendezvousFigure(const team::MergedMap& map,
                                    const std::vector<team::RobotRecord>& robots);

}  // namespace vir::app
