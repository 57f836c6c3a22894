#pragma once
/// Role "estimator": observations in time order in, a state estimate per image out.
#include <mrpt/obs/CObservation.h>

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "vir/core/log.h"
#include "vir/core/options.h"
#include "vir/core/time.h"
#include "vir/geometry/pose.h"

namespace vir {

/// Milliseconds of CPU time in the stages of one image (reporting only).
struct StageTimes {
  double pyramid = 0, flow = 0, detect = 0, initialise = 0, optimise = 0, marginalise = 0,
         total = 0;
};

/// The state as estimated when one image (or odometry pose) was processed: causal.
struct StateEstimate {
  TimeNs t = 0;        ///< stamp of the image
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
  virtual void start(const LogSink& log) = 0;
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
  virtual EstimatorReport report() const = 0;
};

}  // namespace vir
