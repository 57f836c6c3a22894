#pragma once
/// Internal: what the front end hands to the back end, and what comes back.
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "vir/estimator/range_layer.h"
#include "vir/imu/preintegration.h"
#include "vir/types/anchor.h"
#include "vir/types/anchor_range.h"
#include "vir/vision/feature_tracker.h"

namespace vir::estimator {

/// Readings that either side keeps before the oldest time that may still be asked for [s].
constexpr double kImuHistoryS = 2.0;

/// One image as the front end leaves it, with all that came in since the one before.
struct Packet {
  enum class Kind {
    image,           ///< `frame` holds its tracks
    before_imu,      ///< older than the first reading
    silent_imu,      ///< in a hole of the readings
    clock_set_back,  ///< readings begin anew in the past; no image
    lost,            ///< waited for readings when the clock was set back
    end,             ///< of the input; no image
  };
  Kind kind = Kind::image;
  std::vector<ImuSample> readings;
  std::vector<Range> ranges;
  std::vector<AnchorRange> anchor_ranges;
  std::vector<DeployedAnchor> deployed_anchors;
  std::vector<std::string> warnings;  ///< of the front end, told by the back end: one order
  TimeNs stamp = 0;                   ///< the image's own clock
  vision::TrackedFrame frame;         ///< its time is on the clock of the IMU
  double since_last_s = 0;            ///< since the image before; 0 for the first
  double ms = 0;                      ///< CPU time of the front end (reporting only)
  int tracker_resets = 0;             ///< followed by the tracker when it made `frame`
  long feedback = 0;                  ///< packets whose feedback the tracker knew
  double epipolar_px = 0;             ///< see vision::RigTracker
  int cameras = 1;                    ///< whose images were usable, or are the only ones
};

/// Sights of all cameras, the first one's before the others'.
inline std::vector<vision::FeatureObservation> allSights(const vision::TrackedFrame& frame) {
  std::vector<vision::FeatureObservation> out = frame.features;
  out.insert(out.end(), frame.further.begin(), frame.further.end());
  return out;
}

/// Points that are followed, in whatever camera.
inline int tracksOf(const vision::TrackedFrame& frame) {
  std::size_t n = frame.features.size(), j = 0;
  for (std::size_t k = 0; k < frame.further.size(); ++k) {
    const std::uint64_t id = frame.further[k].id;
    if (k > 0 && frame.further[k - 1].id == id) continue;
    while (j < frame.features.size() && frame.features[j].id < id) ++j;
    n += j == frame.features.size() || frame.features[j].id != id;
  }
  return static_cast<int>(n);
}

/// What the tracker needs to know of the state, after each packet.
struct Feedback {
  /// Of the camera by the images alone [rad/s], its frame, while they contradict the readings.
  std::optional<Vec3> turning_C;
  Vec3 gyro_bias = Vec3::Zero();            ///< [rad/s]
  std::vector<std::uint64_t> wrong_tracks;  ///< tracks that were found to be wrong
  double time_offset_s = 0;                 ///< of the camera, as images are to be stamped
  int resets = 0;                           ///< segments begun; older tracks are worthless
  std::optional<Quat> q_B_C;                ///< the camera's rotation, if not as given
  std::vector<Pose> T_B_C;                  ///< of a rig's cameras, as estimated; empty: as before
};

}  // namespace vir::estimator
