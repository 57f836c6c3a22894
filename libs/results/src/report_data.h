#pragma once
/// The numbers that the script of report.html draws.
#include <optional>
#include <string>

#include "frame_history.h"
#include "run_figures.h"
#include "thumbnails.h"
#include "vir/results/run_recorder.h"

namespace vir::results {

/// What an estimate was off at one time, in the frames that its covariance is of.
struct FrameError {
  TimeNs t = 0;
  /// In W, or in a map that the run was found in, whose origin and heading are right at the first
  /// keyframe as that world has it [m].
  Vec3 p = Vec3::Zero();
  Vec3 r = Vec3::Zero();  ///< on the right, in the body [rad]
};

/// T_W_R from the truth's world R to that of `start`, position and yaw, where `start` has no error:
/// an estimator's world has none where it starts. Nothing where the truth does not tell of it.
std::optional<Pose> worldAtStart(const Trajectory& truth, const StampedPose& start);

struct ReportData {
  const RunPictures& pictures;
  const FrameHistory& history;
  const std::vector<FrameError>& errors;  ///< ordered by time; empty without ground truth
  const std::vector<Thumbnail>& images;
  const std::vector<Landmark>& landmarks;
};

/// JSON fit for the inside of a <script>; times are seconds since the first frame, and what is not
/// known is null.
std::string reportJson(const RunSummary& summary, const ReportData& data);

}  // namespace vir::results
