#pragma once
/// What goes over the socket while estimating: JSON, a line each (docs/live.md).
#include <string>

#include "vir/pipeline/estimator.h"
#include "vir/pipeline/pose_propagator.h"

namespace vir::app {

/// {"type":"pose",...}: propagated, per reading of the IMU.
std::string poseLine(const PropagatedPose& pose);
/// {"type":"estimate",...}: per image.
std::string estimateLine(const StateEstimate& estimate);
/// {"type":"anchor",...}.
std::string anchorLine(TimeNs t, const AnchorEstimate& anchor);

}  // namespace vir::app
