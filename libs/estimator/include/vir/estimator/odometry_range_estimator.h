#pragma once
/// Odometry and ranges: poses of a device that drifts (tracking camera, wheels) and ranges to
/// anchors, in the long window alone (the paper's first robot carries such a camera).
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "vir/estimator/range_layer.h"
#include "vir/types/odometry_noise.h"
#include "vir/types/state.h"

namespace vir::estimator {

/// Of a device that is carried or flown.
OdometryNoise odometryNoiseDefaults();

struct OdometryOptions {
  double node_distance_m = 0.25;
  double node_turn_rad = 0.5;
  double node_interval_s = 5.0;
  OdometryNoise noise = odometryNoiseDefaults();
  double max_step_m = 2.0;
  double max_speed_mps = 50;
  double max_gap_s = 2.0;

  /// Throws std::invalid_argument for a value that is not allowed.
  void validate() const;
};
/// Section [Odometry].
void describe(OptionVisitor& v, OdometryOptions& o);

/// Defaults that suit a device of unknown scale: its scale is a state, and an anchor is used as
/// soon as it is roughly known, since the odometry alone will not get better by waiting.
window::LongWindowOptions odometryWindowDefaults();
RangeOptions odometryRangeDefaults();

struct OdometryRangeConfig {
  OdometryOptions odometry;
  window::LongWindowOptions long_window = odometryWindowDefaults();
  RangeOptions ranges = odometryRangeDefaults();
  int iterations = 2;

  /// Throws std::invalid_argument for a value that is not allowed, and for values that contradict
  /// each other.
  void validate() const;
};
/// All sections.
void describe(OptionVisitor& v, OdometryRangeConfig& o);

class OdometryRangeEstimator {
 public:
  /// Throws what `config.validate()` throws.
  explicit OdometryRangeEstimator(const OdometryRangeConfig& config, LogSink log = {});
  ~OdometryRangeEstimator();

  /// Pose of the body in the odometry's frame O, z up, in time order.
  void addOdometry(TimeNs t, const Pose& T_O_B);
  void addRange(const Range& range);
  /// Two anchors have measured how far they are apart.
  void addAnchorRange(const AnchorRange& range);
  /// The robot has just put down an anchor at `p_B` in its body frame; before the first pose this
  /// says nothing of where the anchor is: counted and warned of.
  void anchorDeployed(std::uint64_t id, const Vec3& p_B, double sigma_m);
  std::vector<StateEstimate> take();
  std::vector<RangeRecord> takeRanges();
  /// Nodes that left the window since this was last asked: they do not change any more.
  std::vector<StampedPose> takeSettled();
  std::vector<Anchor> anchors() const;
  /// How the survey of the anchors lies in W; empty without one.
  std::optional<SurveyFit> survey() const;
  /// Nodes as last seen, in W. Beyond some thousand those that left the window are evenly thinned
  /// out, so that memory does not grow for hours.
  std::vector<StampedPose> keyframes() const;
  std::vector<std::pair<std::string, long>> counters() const;
  /// By how much the odometry's steps are too long, as the ranges have it now; 1 without ranges.
  double odometryScale() const;
  const std::vector<std::string>& warnings() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace vir::estimator
