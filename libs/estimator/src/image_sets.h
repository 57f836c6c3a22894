#pragma once
/// Internal: images of several cameras sorted into those of one instant.
#include <deque>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "vir/core/time.h"
#include "vir/vision/feature_tracker.h"

namespace vir::estimator {

/// An image, or the tracks found in one.
struct WaitingImage {
  TimeNs t = 0;    ///< its own clock
  int camera = 0;  ///< of the rig
  cv::Mat gray;
  std::shared_ptr<vision::TrackedFrame> tracks;  ///< instead of an image
  TimeNs at = 0;                                 ///< on the first camera's clock
};

/// Images of one instant, by camera.
struct ImageSet {
  TimeNs t = 0;  ///< of the first camera's, or of the earliest without it; the first one's clock
  std::vector<WaitingImage> images;
};

/// An image of the first camera, and of each other the one nearest to it within half the time
/// between images. A set is complete when each camera has an image or a later one, or time (of the
/// recording) has moved on by as much: no clock is asked. Without an image of the first camera for
/// a while the others go on without it.
class ImageSets {
 public:
  /// `offset`: what is added to the camera's stamps for the first camera's clock.
  void addCamera(TimeNs offset);
  int cameras() const { return static_cast<int>(cameras_.size()); }
  /// False if it is not after the last one of its camera.
  bool add(WaitingImage image);
  /// The next complete set; `all`: whatever is there. `left_out`: by camera, images that have no
  /// place in any set.
  std::optional<ImageSet> next(bool all, std::vector<long>* left_out);
  void clear();

 private:
  struct Camera {
    TimeNs offset = 0;
    std::deque<WaitingImage> waiting;
    TimeNs last = 0;    ///< that came
    TimeNs period = 0;  ///< between images; 0: not known yet
  };
  TimeNs reach() const;
  /// By how much their clocks are apart at most [ns].
  TimeNs clocksApart() const;
  bool firstGoesOn(TimeNs t) const;
  bool complete(TimeNs t) const;

  std::vector<Camera> cameras_;
  TimeNs latest_ = 0;  ///< of any camera
  TimeNs begin_ = 0;
};

}  // namespace vir::estimator
