#pragma once
/// Ranges and anchors between MRPT observations and the estimators' own types.
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "vir/estimator/range_layer.h"
#include "vir/roles/estimator.h"

namespace vir {

/// The ranges of a CObservationBeaconRanges; none for any other class.
std::vector<estimator::RangeMeasurement> rangesOf(const mrpt::obs::CObservation& observation);

/// "The robot has just put down this anchor": a CObservationRobotPose labelled `ANCHOR:<id>` whose
/// pose is the anchor's in the body frame, with the covariance of its position.
struct AnchorEvent {
  std::uint64_t id = 0;
  Vec3 p_B = Vec3::Zero();
  double sigma_m = 0.2;
};
std::optional<AnchorEvent> anchorEventOf(const mrpt::obs::CObservation& observation);

/// Reads the file that [Ranges] bias_model names, if any. Throws std::runtime_error.
void loadBiasModel(estimator::RangeOptions* options);

std::vector<roles::AnchorEstimate> toEstimates(const std::vector<estimator::AnchorReport>& anchors);
std::vector<roles::RangeRecord> toRecords(const std::vector<estimator::RangeDecision>& decisions);

}  // namespace vir
