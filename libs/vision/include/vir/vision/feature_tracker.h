#pragma once
/// The front end: corners found on a grid, followed by pyramidal Lucas-Kanade at half resolution
/// and then aligned at full resolution with the patch each was first seen as, so that errors do not
/// add up along a track. Same input, same bytes out, whatever the number of OpenCV threads.
#include <Eigen/StdVector>
#include <cstdint>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "vir/camera/camera_model.h"
#include "vir/core/options.h"
#include "vir/core/time.h"

namespace vir::vision {

struct TrackerOptions {
  int max_tracks = 150;
  double min_distance_px = 25;
  int grid_cell_px = 60;
  int pyramid_levels = 3;
  int window_px = 21;  ///< edge of the patch that finds the way
  int patch_px = 15;   ///< edge of the patch that fixes the position
  int max_iterations = 8;
  double forward_backward_px = 0.7;  ///< 0 = no backward check
  double outlier_px = 1.0;           ///< distance from the epipolar line given the known rotation
  double min_corner_score = 20;
  double min_similarity = 0.88;  ///< normalised cross-correlation with the remembered patch

  /// Throws std::invalid_argument for a value that is not allowed.
  void validate() const;
};
void describe(OptionVisitor& v, TrackerOptions& o);

/// One feature in one image.
struct FeatureObservation {
  std::uint64_t id = 0;  ///< never reused in a run
  int age = 0;           ///< images this track has been seen in before this one
  Vec2 px = Vec2::Zero();
  Vec3 bearing = Vec3::UnitZ();        ///< unit, camera frame
  Mat23 dpx_dbearing = Mat23::Zero();  ///< projection Jacobian at `bearing` [px]
  Vec3 bearing_rate = Vec3::Zero();    ///< d bearing / dt [1/s], zero for a new track
  int camera = 0;                      ///< of the rig
  double noise = 1;                    ///< of its pixel, against that of other sights
};

/// What the tracker says of one image.
struct TrackedFrame {
  TimeNs t = 0;
  std::vector<FeatureObservation> features;  ///< of the first camera, ordered by id
  /// Of the other cameras of a rig, as seen at `t`, ordered by id and camera; what two cameras see
  /// of one point has one id.
  std::vector<FeatureObservation> further;
  int continued = 0;              ///< tracks carried over from the previous image
  int lost_flow = 0;              ///< not found again, looks different, or left the image
  int lost_backward = 0;          ///< forward-backward check failed
  int lost_outlier = 0;           ///< contradicts the common motion
  int lost_crowded = 0;           ///< came too close to an older track
  int detected = 0;               ///< new corners
  double median_flow_px = 0;      ///< median image motion of the continued tracks
  double median_parallax_px = 0;  ///< the same after the predicted rotation is taken out
  double mean_intensity = 0;      ///< 0..255
  bool usable = true;             ///< false: empty, wrong size or type, blank; `reason` says why
  std::string reason;
  double ms_pyramid = 0, ms_flow = 0, ms_detect = 0;  ///< for frames.csv only, never for decisions
};

class FeatureTracker {
 public:
  /// Throws std::invalid_argument without a camera or for an option that is not allowed. `number`:
  /// of the camera in a rig; no two have ids in common.
  FeatureTracker(const TrackerOptions& options, std::shared_ptr<const camera::CameraModel> camera,
                 int number = 0);
  ~FeatureTracker();
  /// Follows the features into `gray` (CV_8UC1; not kept, not modified). `R_C0_C1` takes
  /// coordinates in this camera frame to the camera frame of the last *usable* image, from the
  /// gyro; it may be wrong by a gyro bias of about 0.1 rad/s. Anything that is not a rotation is
  /// replaced by identity and `reason` says so. An unusable image drops no state: the next one is
  /// matched against the last usable, so after it the caller must hand over the rotation over the
  /// whole time in between.
  TrackedFrame process(TimeNs t, const cv::Mat& gray, const Mat3& R_C0_C1);
  /// Where no gyro is to be believed: the camera is expected to go on turning by `rate` [rad/s], in
  /// its frame, give or take 0.5 rad/s.
  TrackedFrame processTurning(TimeNs t, const cv::Mat& gray, const Vec3& rate);
  /// The back end found these to be wrong: stop following them.
  void stopFollowing(const std::vector<std::uint64_t>& ids);
  /// Forgets all tracks (after a gap).
  void reset();

 private:
  friend class RigTracker;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace vir::vision
