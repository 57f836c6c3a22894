#pragma once
/// Between MRPT observations and the project's own types.
#include <mrpt/obs/CObservation.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "vir/types/anchor.h"
#include "vir/types/calibration.h"
#include "vir/types/imu_sample.h"
#include "vir/types/peer_broadcast.h"
#include "vir/types/range.h"
#include "vir/types/state.h"

namespace mrpt::obs {
class CObservationBeaconRanges;
class CObservationIMU;
class CObservationRobotPose;
}  // namespace mrpt::obs

namespace vir::rawlog {

/// Empty for other classes, and where one of the six values is missing.
std::optional<ImuSample> imuSampleOf(const mrpt::obs::CObservation& observation);
/// Labelled `label`.
std::shared_ptr<mrpt::obs::CObservationIMU> toObservation(const ImuSample& sample,
                                                          const std::string& label);

/// The ranges of a CObservationBeaconRanges, a negative id of the radio as one above 2^31; none for
/// any other class.
std::vector<Range> rangesOf(const mrpt::obs::CObservation& observation);
/// From where to where a radio measures [m]; by itself what MRPT assumes.
struct RadioReach {
  double min_m = 0, max_m = 100;
};
/// Of importers, which do not know the radio.
constexpr RadioReach kUnknownRadio{0, 1000};
/// One observation for one range, since MRPT keeps one standard deviation for all of them.
std::shared_ptr<mrpt::obs::CObservationBeaconRanges> toObservation(const Range& range,
                                                                   const std::string& label,
                                                                   const RadioReach& reach = {});

/// The mean of a CObservationRobotPose; empty for any other class.
std::optional<StampedPose> poseOf(const mrpt::obs::CObservation& observation);
/// With a covariance of 0.
std::shared_ptr<mrpt::obs::CObservationRobotPose> toObservation(const StampedPose& pose,
                                                                const std::string& label);

/// "The robot has just put down this anchor": a CObservationRobotPose labelled `ANCHOR:<id>` whose
/// pose is the anchor's in the body frame, with the covariance of its position.
std::optional<DeployedAnchor> deployedAnchorOf(const mrpt::obs::CObservation& observation);

/// A CObservationRobotPose labelled as a broadcast (labels.h): a position with its covariance and
/// no attitude. Empty for any other class or label; what it says may be no number.
std::optional<PeerBroadcast> broadcastOf(const mrpt::obs::CObservation& observation,
                                         const std::string& peer_label);
std::shared_ptr<mrpt::obs::CObservationRobotPose> toObservation(const PeerBroadcast& broadcast,
                                                                const std::string& peer_label);

/// A CObservationRobotPose labelled as the pose of another robot (labels.h): its body's pose with
/// the covariance of the position, its antenna as the sensor's place on it. Empty for any other
/// class or label; what it says may be no number.
std::optional<PeerPose> peerPoseOf(const mrpt::obs::CObservation& observation,
                                   const std::string& peer_label);
std::shared_ptr<mrpt::obs::CObservationRobotPose> toObservation(const PeerPose& pose,
                                                                const std::string& peer_label);

/// The camera that comes with an image; empty for any other class.
std::optional<Calibration> calibrationOf(const mrpt::obs::CObservation& observation);
/// That of the first image labelled `camera_label`, once `given` (what goes before the recording)
/// has changed it. Throws std::runtime_error if there is none, and as RawlogReader does.
Calibration calibrationIn(const std::string& rawlog, const std::string& camera_label,
                          const std::function<void(mrpt::obs::CObservation*)>& given = {});

/// An image, or the feature tracks that stand for one.
bool isImage(const mrpt::obs::CObservation& observation);

}  // namespace vir::rawlog
