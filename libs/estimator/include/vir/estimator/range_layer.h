#pragma once
/// Ranges on their way into the double window: checked, predicted, gated, and anchors found from
/// them, watched, and found anew when they turn out to be elsewhere.
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "vir/core/log.h"
#include "vir/core/options.h"
#include "vir/ranging/range_bias_model.h"
#include "vir/window/long_window.h"

namespace vir::estimator {

struct RangeOptions {
  bool use = true;  ///< [Estimator] use_ranges
  double sigma_m = 0.1;
  double sigma_scale = 1.0;
  double bias_sigma_m = 0.03;
  double max_range_m = 500;
  bool correlation = true;
  double gate_sigma = 4.0;
  int min_ranges = 20;
  double max_anchor_sigma_m = 1.0;
  double drift_ratio = 0.01;
  double path_scale_sigma = 0.02;
  double restart_s = 3.0;
  std::vector<double> anchor_prior;
  std::string bias_model_file;         ///< for the caller, who reads it into:
  ranging::RangeBiasModel bias_model;  ///< b_d(d) of the paper; empty: none
};
/// Section [Ranges].
void describe(OptionVisitor& v, RangeOptions& o);

/// A range as it comes from the radio.
struct RangeMeasurement {
  TimeNs t = 0;  ///< its own time, on the clock of the IMU (or odometry)
  std::uint64_t anchor = 0;
  double range_m = 0;
  double sigma_m = 0;         ///< <= 0: not known, the setting is used
  Vec3 p_B_U = Vec3::Zero();  ///< antenna in the body [m]
};

/// What became of one range when it was processed.
struct RangeDecision {
  TimeNs t = 0;
  std::uint64_t anchor = 0;
  double measured_m = 0, predicted_m = 0, residual_m = 0, sigma_m = 0, weight = 0;
  std::string decision;
};

/// An anchor as now known.
struct AnchorReport {
  std::uint64_t id = 0;
  bool has_position = false;
  Vec3 p_W = Vec3::Zero();
  Mat3 covariance = Mat3::Zero();
  double bias_m = 0, bias_sigma_m = 0;
  std::string state, advice;
  Vec3 mirror_p_W = Vec3::Zero();
  long used = 0, rejected = 0;
};

/// Where the antenna was when a range was measured.
struct AntennaPrediction {
  Vec3 p_W = Vec3::Zero();
  Mat3 inner_covariance = Mat3::Zero();  ///< against the front of the long window [m^2]
};

class RangeLayer {
 public:
  RangeLayer(const RangeOptions& options, window::LongWindow* window, LogSink log);
  ~RangeLayer();

  /// Takes a range; what cannot be used at all is recorded with its reason.
  void offer(const RangeMeasurement& range);
  /// Ranges up to `t`, oldest first, taken out of the queue.
  std::vector<RangeMeasurement> dueUntil(TimeNs t);
  /// Records ranges that came when there was no pose to hang them on.
  void discard(const std::vector<RangeMeasurement>& ranges, const std::string& why);

  /// Decides on a range and records it. True: it is to be held by a keyframe; `held` has all but
  /// the two vectors filled in.
  bool judge(const RangeMeasurement& range, const AntennaPrediction& antenna,
             window::HeldRange* held);

  /// All held ranges of an anchor, the antenna's position in W in `motion`.
  using Held = std::function<std::vector<window::HeldRange>(std::uint64_t key)>;
  /// Once per keyframe: finds new anchors, settles mirror images, reweighs correlated ranges,
  /// notices anchors that are no longer where they were. True if the anchors changed so much that
  /// the window is to be solved again.
  /// `front`: all ranges held after the long window's nodes, as if at its front.
  bool update(TimeNs t, const Held& held, const std::vector<window::HeldRange>& front);

  /// The robot says that it dropped an anchor at `p_W` (standard deviation `sigma_m`).
  void dropped(std::uint64_t id, const Vec3& p_W, double sigma_m);

  std::vector<AnchorReport> anchors() const;
  std::vector<RangeDecision> take();
  std::vector<std::pair<std::string, long>> counters() const;
  std::vector<std::string> takeWarnings();
  bool anyPending() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace vir::estimator
