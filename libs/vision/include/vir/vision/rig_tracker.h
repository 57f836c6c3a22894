#pragma once
/// The front end of several cameras: each follows its features in time, and what two of them see of
/// one point is found along the epipolar curve and followed under one id.
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "vir/geometry/pose.h"
#include "vir/vision/feature_tracker.h"

namespace vir::vision {

/// An image of one camera of the rig.
struct RigImage {
  int camera = 0;
  TimeNs t = 0;  ///< on the clock that all cameras share
  cv::Mat gray;
  /// As for FeatureTracker::process(): since the last usable image of this camera.
  Mat3 R_C0_C1 = Mat3::Identity();
};

/// What became of an image.
struct RigOutcome {
  int camera = 0;
  bool usable = true;
  std::string reason;  ///< why not
};

class RigTracker {
 public:
  struct Camera {
    std::shared_ptr<const camera::CameraModel> model;
    Pose T_B_C;
  };

  /// `max_tracks` is what all cameras may have together, a point that two of them see counting
  /// twice. Throws what FeatureTracker throws.
  RigTracker(const TrackerOptions& options, const std::vector<Camera>& cameras);
  ~RigTracker();

  /// Images of one instant `t`, at most one of each camera, by ascending camera. Sights of images
  /// that were taken beside it are carried there by how they move. Usable if one of the images is.
  /// With one camera: FeatureTracker::process().
  TrackedFrame process(TimeNs t, const std::vector<RigImage>& images,
                       std::vector<RigOutcome>* outcomes = nullptr);
  /// See FeatureTracker::processTurning(); `rate`: of the first camera in its frame.
  TrackedFrame processTurning(TimeNs t, const std::vector<RigImage>& images, const Vec3& rate,
                              std::vector<RigOutcome>* outcomes = nullptr);
  /// Where the cameras are by now, as far as known: for matches between them.
  void setExtrinsics(const std::vector<Pose>& T_B_C);
  /// Of all cameras: see FeatureTracker.
  void stopFollowing(const std::vector<std::uint64_t>& ids);
  void reset();
  /// Forgets the tracks of one camera.
  void reset(int camera);
  /// Do these two see the same part of a scene a few metres away?
  bool overlap(int a, int b) const;
  /// How far matches lie beside their epipolar curves [px], median of the latest; 0 with hardly
  /// any.
  double epipolarPx() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace vir::vision
