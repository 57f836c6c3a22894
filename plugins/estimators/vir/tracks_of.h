#pragma once
/// Feature tracks from a rawlog, as the feature tracker would have reported them.
#include <map>
#include <memory>

#include "vir/camera/camera_model.h"
#include "vir/vision/feature_tracker.h"

namespace mrpt::obs {
class CObservationStereoImagesFeatures;
}

namespace vir {

/// Takes the left camera's features; ids tell which belong together.
class TrackReader {
 public:
  /// The features of one image, in order of time. What cannot be a feature (a pixel that is not
  /// finite or outside of the image, an id for the second time) is left out and counted.
  vision::TrackedFrame read(const mrpt::obs::CObservationStereoImagesFeatures& observation,
                            const camera::CameraModel& camera);
  long unusable() const { return unusable_; }

 private:
  bool observe(const camera::CameraModel& camera, vision::FeatureObservation* f) const;

  std::map<std::uint64_t, vision::FeatureObservation> last_;  ///< of the image before
  TimeNs last_t_ = 0;
  long unusable_ = 0;
};

}  // namespace vir
