#pragma once
/// The pictures of a run. All are drawn in the estimate's world; times are seconds since the first
/// frame.
#include <map>
#include <optional>
#include <vector>

#include "vir/evaluation/evaluate.h"
#include "vir/evaluation/figure.h"
#include "vir/roles/estimator.h"
#include "vir/types/loop_record.h"

namespace vir::results {

/// What there is to be shown; refers to what the caller keeps.
struct RunPictures {
  TimeNs first_frame = 0;
  const Trajectory& causal;
  const Trajectory& smoothed;
  const Trajectory& truth;  ///< in its own world
  /// Of the causal trajectory against the truth, position and yaw aligned.
  const std::optional<evaluation::EvaluationResult>& evaluation;
  /// Per causal pose: root of the trace of the position's covariance [m]; 0 = not known.
  const std::vector<double>& position_sigma_m;
  /// Per frame: stamp and CPU time [ms].
  const std::vector<std::pair<TimeNs, double>>& cpu_ms;
  const std::vector<Anchor>& anchors;
  const std::map<std::uint64_t, Vec3>& true_anchors;  ///< in the truth's world
  const std::vector<RangeRecord>& ranges;
  /// Per frame; empty where it was not estimated.
  const std::vector<roles::CalibrationPoint>& calibrations;
  const std::optional<Calibration>& calibration_given;
  std::vector<LoopRecord> loops = {};  ///< accepted ones are drawn
};

/// Paths from above and from the side, anchors with their 2 sigma ellipses, mirror positions and,
/// where they are known, true positions.
evaluation::Figure mapFigure(const RunPictures& run);

/// Residuals over time, a panel per anchor (the four with the most ranges), coloured by decision.
/// No panels if there are no ranges with a prediction.
evaluation::Figure rangesFigure(const RunPictures& run);

/// Position error over time within three standard deviations. No panels without ground truth.
evaluation::Figure errorFigure(const RunPictures& run);

/// Time offset, focal length, rotation and position of the camera over time, less what was given,
/// each within one standard deviation. No panels where it was not estimated.
evaluation::Figure calibrationFigure(const RunPictures& run);

/// CPU time per frame. No panels if no time was reported.
evaluation::Figure cpuFigure(const RunPictures& run);

}  // namespace vir::results
