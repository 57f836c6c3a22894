#pragma once
/// What happens in the simulated world as observations of stock MRPT classes; whoever gives them
/// out stamps them.
#include <mrpt/obs/CObservation.h>
#include <mrpt/obs/CObservationImage.h>

#include <vector>

#include "world.h"

namespace vir::simulator {

/// One range. Label UWB0 (to an anchor) or PEER.
mrpt::obs::CObservation::Ptr rangeObservation(const char* label,
                                              const simulation::SimulatedRange& range,
                                              const Vec3& antenna, double sigma_m);
/// What robot `peer` tells with a range: label PEER:<id>, and PEER:<id>:ANCHOR:<a> per anchor. Each
/// holds a position with its covariance and no attitude.
mrpt::obs::CObservation::Ptr toldObservation(int peer, const simulation::ToldPosition& told);
/// Of camera 0, 1, ...: label CAM0, CAM1, ..., all but the pixels.
mrpt::obs::CObservationImage::Ptr emptyImage(int camera, const CameraCalibration& calibration,
                                             const Pose& T_B_C);
/// Label TRACKS0: the features seen by the camera as its left images' features; the right camera is
/// the same one again.
mrpt::obs::CObservation::Ptr tracksObservation(const vision::TrackedFrame& frame,
                                               const CameraCalibration& calibration,
                                               const Pose& T_B_C);

}  // namespace vir::simulator
