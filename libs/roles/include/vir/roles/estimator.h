#pragma once
/// Role "estimator": observations in time order in, a state estimate per image out.
#include <mrpt/obs/CObservation.h>

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "vir/core/log.h"
#include "vir/core/options.h"
#include "vir/core/time.h"
#include "vir/geometry/pose.h"
#include "vir/roles/peer_result.h"

namespace vir::roles {

/// Milliseconds of CPU time in the stages of one image (reporting only).
struct StageTimes {
  double pyramid = 0, flow = 0, detect = 0, initialise = 0, optimise = 0, marginalise = 0,
         total = 0;
};

/// The state as estimated when one image (or odometry pose) was processed: causal.
struct StateEstimate {
  TimeNs t = 0;        ///< stamp of the image
  TimeNs t_imu = 0;    ///< the same moment on the clock of the IMU
  bool valid = false;  ///< false before initialisation and when lost: `health` says why
  Pose T_W_B;
  Vec3 v_W_B = Vec3::Zero();      ///< [m/s]
  Vec3 bias_gyro = Vec3::Zero();  ///< [rad/s]
  Vec3 bias_acc = Vec3::Zero();   ///< [m/s^2]
  /// Covariance of (position in W [m], rotation on the right [rad]); zero if unknown.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  int segment = 0;  ///< counts up when the estimator had to start anew
  bool keyframe = false;
  int tracks = 0;
  int landmarks = 0;
  std::string health;  ///< "ok", or a short reason: "too little parallax", "standstill", ...
  StageTimes ms;
};

struct LandmarkEstimate {
  std::uint64_t id = 0;
  Vec3 p_W = Vec3::Zero();
};

struct KeyframeEstimate {
  TimeNs t = 0;
  Pose T_W_B;
};

/// An anchor as now estimated, in W.
struct AnchorEstimate {
  std::uint64_t id = 0;
  Vec3 p_W = Vec3::Zero();         ///< [m]
  Mat3 covariance = Mat3::Zero();  ///< [m^2]
  double bias_m = 0;               ///< constant part of its ranges that is no distance
  double bias_sigma_m = 0;
  /// "collecting" (no position yet; `advice` says what is missing), "mirror_open" (a second
  /// position explains the ranges as well), "estimated", "fixed", "moved" (its ranges contradict
  /// it: being found anew).
  std::string state;
  std::string advice;              ///< e.g. "move sideways: the path so far is a straight line"
  Vec3 mirror_p_W = Vec3::Zero();  ///< the other position while "mirror_open"
  long ranges_used = 0, ranges_rejected = 0;
  bool has_position = false;
};

/// What became of one range, as decided when it was processed (causal).
struct RangeRecord {
  TimeNs t = 0;
  std::uint64_t id = 0;
  double measured_m = 0;
  double predicted_m = 0;  ///< bias included; 0 if there is no prediction
  double residual_m = 0;   ///< measured - predicted; 0 if there is no prediction
  double sigma_m = 0;      ///< of the prediction and the range together; 0 if none
  double weight = 0;       ///< of the robust loss, 0..1
  std::string decision;    ///< "accepted", "collected" (no position yet), or why not used
};

/// Counted, never silent: what the estimator could not use, and what happened to it.
struct EstimatorReport {
  std::vector<std::pair<std::string, long>> counters;  ///< e.g. {"images_unusable", 3}
  std::vector<std::string> warnings;
  int resets = 0;
  std::string longest_wait_reason;  ///< why initialisation took as long as it did
};

class Estimator {
 public:
  virtual ~Estimator() = default;
  /// Declares the settings; called before start().
  virtual void describe(OptionVisitor& v) = 0;
  /// Live use, before start(): the estimator may work on in a thread of its own when add() has
  /// returned, and calls `on_estimates` from there when there is something to take. In that call
  /// all but report() may be asked, and everything after finish(), which ends the calls even if it
  /// throws; at other times only add() and finish() may be called. False: it has no such thread,
  /// and works in add().
  virtual bool workBehind(std::function<void()> /*on_estimates*/) { return false; }
  virtual void start(const LogSink& log) = 0;
  /// Does add() make use of such an observation (by its label)?
  virtual bool reads(const mrpt::obs::CObservation& /*observation*/) const { return true; }
  /// One observation; the caller keeps time order per sensor. Must not keep a reference to the
  /// image after it returns unless it copies it.
  virtual void add(const mrpt::obs::CObservation& observation) = 0;
  /// The input has ended: process what is queued.
  virtual void finish() = 0;
  /// The estimates made since the last call, oldest first.
  virtual std::vector<StateEstimate> take() = 0;
  /// Map points that left the window since the start, and those in it.
  virtual std::vector<LandmarkEstimate> landmarks() const = 0;
  /// Keyframes as the window last saw them.
  virtual std::vector<KeyframeEstimate> keyframes() const = 0;
  /// Anchors ordered by id; none if the estimator uses no ranges.
  virtual std::vector<AnchorEstimate> anchors() const { return {}; }
  /// Ranges decided on since the last call, in time order.
  virtual std::vector<RangeRecord> takeRanges() { return {}; }
  /// Other robots that were ranged to, ordered by id; none if nobody follows them.
  virtual std::vector<PeerResult> peers() const { return {}; }
  /// Where features were seen in the last image [px]; none if the estimator uses no images.
  virtual std::vector<Eigen::Vector2f> trackedPixels() const { return {}; }
  virtual EstimatorReport report() const = 0;
};

}  // namespace vir::roles
