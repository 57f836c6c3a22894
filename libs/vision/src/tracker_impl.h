#pragma once
/// The state of FeatureTracker and its steps: feature_tracker.cpp holds the frame around them,
/// track_following.cpp how a track gets from one image to the next.
#include <Eigen/Dense>
#include <algorithm>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "image_pyramid.h"
#include "patch.h"
#include "vir/core/stage_timer.h"
#include "vir/vision/corner_detector.h"
#include "vir/vision/feature_tracker.h"

namespace vir::vision {

inline Vec2 toVec(const cv::Point2f& p) { return {p.x, p.y}; }
inline cv::Point2f toPoint(const Vec2& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y())};
}

/// Of an id: what comes above them is the number of the camera that saw it first.
constexpr int kIdBits = 48;

/// Of all grey levels of an image.
struct Brightness {
  double mean = 0.0, deviation = 0.0;
};

/// A feature as last seen, with the patch it is recognised by.
struct Track {
  FeatureObservation seen;
  Patch patch;
  PatchWarp warp;  ///< patch to the last usable image
};

/// How wrong the gyro's rotation may be before its bias is known, and one that just goes on
/// [rad/s].
constexpr double kRotationRateSigma = 0.08, kSteadyRateSigma = 0.5;

/// A track found in the new image; nothing of the state changes until all of them are known.
struct Followed {
  std::size_t from = 0;  ///< index of the track
  FeatureObservation now;
  PatchWarp warp;
  Patch renewed;  ///< replaces the track's patch unless empty
};

struct FeatureTracker::Impl {
  Impl(const TrackerOptions& o, std::shared_ptr<const camera::CameraModel> c)
      : options(o),
        camera(std::move(c)),
        window(std::max(5, (o.window_px / 2) | 1)),
        levels(std::max(1, o.pyramid_levels)),
        border(o.patch_px / 2 + 2),
        detector(
            {o.grid_cell_px / 2, 0.5 * o.min_distance_px, o.min_corner_score, (border + 1) / 2}) {}

  /// `rate_sigma`: how wrong the rotation may be [rad/s].
  TrackedFrame process(TimeNs t, const cv::Mat& gray, const Mat3& R_C0_C1, double rate_sigma);
  /// The first half of it: tracks are those found in `current`, which is `gray`, unless the frame
  /// is not usable.
  TrackedFrame followInto(TimeNs t, const cv::Mat& gray, const Mat3& R_C0_C1, double rate_sigma);
  /// The second half: new corners, as many as `budget` leaves room for ...
  void detect(TrackedFrame* frame);
  /// ... and what was found; `current` becomes `last`.
  void conclude(TrackedFrame* frame);
  /// Begins a track at `px` of `current` under the id another camera gave it. False where there is
  /// no texture or no room.
  bool adopt(std::uint64_t id, const Vec2& px);
  std::string refuse(const cv::Mat& gray) const;
  const ImagePyramid& matchExposure(const Brightness& now);
  void predict(const Mat3& R_C0_C1, int* lost);
  void follow(const Mat3& R_C0_C1, const ImagePyramid& target, TrackedFrame* frame);
  bool align(const Track& track, const cv::Point2f& start, Followed* f) const;
  /// `sigma`: of `R_C0_C1` [rad].
  void rejectOutliers(const Mat3& R_C0_C1, double sigma, double dt, TrackedFrame* frame);
  /// Follows with the camera turned as predicted; where that loses nearly all and another turn
  /// finds them, `R_C0_C1` is that one.
  void followAsTurned(double rate_sigma, double dt, const ImagePyramid& target, Mat3* R_C0_C1,
                      TrackedFrame* frame);
  void thinOut(TrackedFrame* frame);
  bool observe(const Vec2& px, FeatureObservation* f) const;
  bool insideBorder(const Vec2& p) const;
  void summarise(const Mat3& R_C0_C1, TrackedFrame* frame) const;
  void keepFollowed();
  bool tooDark(const Brightness& now, TimeNs t) const;

  TrackerOptions options;
  std::shared_ptr<const camera::CameraModel> camera;
  int window;  ///< of Lucas-Kanade at half resolution
  int levels;
  int border;
  CornerDetector detector;

  std::vector<Track> tracks;       ///< in the last usable image, ordered by id
  std::vector<Followed> followed;  ///< those of them found in the new image, in the same order
  int number = 0;                  ///< of the camera
  std::uint64_t next_id = 0;
  int budget = options.max_tracks;  ///< tracks it may have
  TimeNs last_t = 0;
  TimeNs before_last_t = 0;     ///< of the image before that (kept by RigTracker)
  Vec3 turning = Vec3::Zero();  ///< of the camera before the last usable image [rad/s]
  ImagePyramid last, current, matched;
  Brightness last_brightness, current_brightness;
  StageLaps watch;
  cv::Mat matched_image;

  std::vector<cv::Point2f> start, forward, back;  ///< [px of the half resolution]
  std::vector<unsigned char> found, found_back;
};

}  // namespace vir::vision
