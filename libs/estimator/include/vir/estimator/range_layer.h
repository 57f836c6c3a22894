#pragma once
/// Ranges on their way into the double window: checked, predicted, gated, and anchors found from
/// them, watched, and found anew when they turn out to be elsewhere.
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "vir/core/log.h"
#include "vir/core/options.h"
#include "vir/ranging/range_bias_model.h"
#include "vir/types/anchor.h"
#include "vir/types/anchor_range.h"
#include "vir/types/range.h"
#include "vir/types/survey.h"
#include "vir/window/long_window.h"

namespace vir::estimator {

struct RangeOptions {
  bool use = true;  ///< [Estimator] use_ranges
  double sigma_m = 0.1;
  double sigma_scale = 1.0;
  double bias_sigma_m = 0.03;
  double uncalibrated_bias_sigma_m = 0.7;
  double max_range_m = 500;
  bool correlation = true;
  double gate_sigma = 4.0;
  int min_ranges = 20;
  double max_anchor_sigma_m = 1.0;
  double floor_sigma_m = 5.0;
  double drift_ratio = 0.01;
  double path_scale_sigma = 0.02;
  double restart_s = 3.0;
  std::vector<double> anchor_prior;
  std::string bias_model_file;         ///< for the caller, who reads it into:
  ranging::RangeBiasModel bias_model;  ///< b_d(d) of the paper; empty: none
  std::string surveyed_anchors;        ///< for the caller, who reads it into:
  std::vector<SurveyedAnchor> survey;  ///< anchors with positions in a frame of their own
  std::string anchor_names;            ///< for who reads it: `name=number`, repeated

  /// Throws std::invalid_argument for a value that is not allowed, and for values that contradict
  /// each other.
  void validate() const;
};
/// Section [Ranges].
void describe(OptionVisitor& v, RangeOptions& o);

/// Where the antenna was when a range was measured.
struct AntennaPrediction {
  Vec3 p_W = Vec3::Zero();
  Mat3 inner_covariance = Mat3::Zero();  ///< against the head of the long window [m^2]
};

class RangeLayer {
 public:
  RangeLayer(const RangeOptions& options, window::LongWindow* window, LogSink log);
  ~RangeLayer();

  /// The first image, or pose: times are told since then.
  void begin(TimeNs t);
  /// Takes a range or a difference of ranges; what cannot be used at all is recorded with its
  /// reason.
  void offer(const Range& range);
  /// A range between two anchors, which ties them; what cannot be is counted.
  void offer(const AnchorRange& range);
  /// Ranges up to `t`, oldest first, taken out of the queue.
  std::vector<Range> dueUntil(TimeNs t);
  /// Records ranges that came when there was no pose to hang them on.
  void discard(const std::vector<Range>& ranges, RangeDecision why);

  /// Decides on a range and records it. True: it is to be held by a keyframe; `held` has all but
  /// the two vectors filled in.
  bool accept(const Range& range, const AntennaPrediction& antenna, window::HeldRange* held);

  /// All held ranges of an anchor, no differences, the antenna's position in W in `motion`.
  using Held = std::function<std::vector<window::HeldRange>(std::uint64_t key)>;
  /// Once per keyframe: finds new anchors, settles mirror images, reweighs correlated ranges,
  /// notices anchors that are no longer where they were. True if the anchors changed so much that
  /// the window is to be solved again.
  /// `head`: all ranges held after the long window's nodes, as if at its head.
  /// `differences`: all of them that are held, the antenna's position in W in `motion`.
  using HeldDifferences = std::function<std::vector<window::HeldRange>()>;
  bool update(TimeNs t, const Held& held, const std::vector<window::HeldRange>& head,
              const HeldDifferences& differences);

  /// An image that is no keyframe: one piece of the work that update() has put off, if there is
  /// any.
  void betweenKeyframes(const Held& held);

  /// The robot says that it has put down an anchor at `p_W` (standard deviation `sigma_m`). What
  /// cannot be is counted and warned of.
  void putDown(std::uint64_t id, const Vec3& p_W, double sigma_m);
  /// It says so, but nobody knows where it was then: counted and warned of.
  void putDownUnseen(std::uint64_t id);

  std::vector<Anchor> anchors() const;
  /// How the survey lies in W; empty without one.
  std::optional<SurveyFit> survey() const;
  std::vector<RangeRecord> take();
  std::vector<std::pair<std::string, long>> counters() const;
  std::vector<std::string> takeWarnings();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace vir::estimator
