#pragma once
/// What goes over the socket while estimating: JSON, a line each (docs/live.md).
#include <string>

#include "vir/live/pose_propagator.h"
#include "vir/roles/estimator.h"

namespace vir::app {

/// {"type":"pose",...}: propagated, per reading of the IMU.
std::string poseLine(const live::PropagatedPose& pose);
/// {"type":"estimate",...}: per image.
std::string estimateLine(const roles::StateEstimate& estimate);
/// {"type":"anchor",...}.
std::string anchorLine(TimeNs t, const roles::AnchorEstimate& anchor);

}  // namespace vir::app
