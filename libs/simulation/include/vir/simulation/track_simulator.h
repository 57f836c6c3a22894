#pragma once
/// What a feature tracker would report along a motion, without images: points of a room projected
/// with noise, tracks that come and go, some of them wrong.
#include <memory>
#include <vector>

#include "vir/camera/camera_model.h"
#include "vir/core/options.h"
#include "vir/rendering/scene.h"
#include "vir/simulation/motion.h"
#include "vir/vision/feature_tracker.h"

namespace vir::simulation {

struct TrackSimulationOptions {
  double rate_hz = 20;
  double phase_s = 0.0023;  ///< of the first image after the motion's begin
  int max_tracks = 150;
  double min_distance_px = 25;
  /// A real tracker's tracks live shortly or long: median 4 to 12 images, mean 14 to 22 on our
  /// recordings. A share of the corners is weak.
  double mean_track_images = 30;
  double weak_share = 0.4;
  double weak_track_images = 4;
  double noise_px = 0.3;        ///< white, per axis
  double offset_px = 0.3;       ///< constant along a track, per axis
  double drift_px = 0.1;        ///< random walk along a track, per axis and square root of images
  double rest_noise = 0.2;      ///< factor of the white noise when the image stands still
  double outlier_share = 0.02;  ///< of the tracks that slide off their point at some time
  double outlier_px = 1.5;      ///< how fast, per image
  double room_margin_m = 2;     ///< the room is the path's bounding box grown by this
  double wall_density = 30;     ///< points per m^2 of walls, floor and ceiling
  double free_share = 0.4;      ///< points standing free near the path, per point of the walls
  double min_depth_m = 0.3, max_distance_m = 25;
  double readout_s = 0;            ///< rolling shutter: first row to last; the middle is seen at t
  std::vector<double> blackout_s;  ///< from to, from to ...: images are dark
  std::vector<double> blind_s;     ///< from to ...: images without any texture, few tracks
  int seed = 1;
};
/// Section [SimulatedTracks].
void describe(OptionVisitor& v, TrackSimulationOptions& o);

/// Everything is a function of the settings and the times asked for.
class TrackSimulator {
 public:
  /// `motion` and `camera` are shared with the caller. `T_B_C`: camera in the body. With a `scene`
  /// the points are on its surfaces and hide behind its boxes; without, they are on the walls of a
  /// room around the path and standing free in it, and nothing hides them. Throws
  /// std::invalid_argument.
  TrackSimulator(const TrackSimulationOptions& options, std::shared_ptr<const Motion> motion,
                 std::shared_ptr<const camera::CameraModel> camera, const Pose& T_B_C,
                 std::shared_ptr<const rendering::Scene> scene = nullptr);
  ~TrackSimulator();

  /// Stamps of the images of the whole motion.
  std::vector<TimeNs> times() const;
  /// The next image; times must ascend. Filled as FeatureTracker does; ms_* stay 0.
  vision::TrackedFrame at(TimeNs t);
  /// These are not followed any more, as with FeatureTracker::stopFollowing.
  void stopFollowing(const std::vector<std::uint64_t>& ids);
  /// True position in W of the point a track was started on; false for an unknown id.
  bool pointOf(std::uint64_t id, Vec3* p_W) const;
  std::size_t points() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace vir::simulation
