#pragma once
/// Ranges from an antenna on the body to anchors, with what goes wrong in practice.
#include <optional>
#include <vector>

#include "vir/core/options.h"
#include "vir/rendering/scene.h"
#include "vir/simulation/motion.h"

namespace vir::simulation {

struct RangeSimulationOptions {
  std::vector<double> anchor_m;              ///< x y z in W per anchor
  std::vector<double> anchor_id;             ///< empty: 0, 1, 2 ...
  std::vector<double> lever_arm_m{0, 0, 0};  ///< p_B_U, antenna in the body
  double rate_hz = 20;                       ///< per anchor
  double jitter = 0.4;                       ///< of the period, to either side
  double sigma_m = 0.05;                     ///< white
  double correlated_sigma_m = 0;             ///< of a first-order Markov part
  double correlated_s = 0.75;                ///< its time constant
  double bias_m = 0;                         ///< added to all
  std::vector<double> bias_curve;  ///< distance, bias, distance, bias ...: linear in between
  double nlos_share = 0;           ///< of the ranges without line of sight
  double nlos_min_m = 0.3, nlos_max_m = 1.8;  ///< how much longer they are
  double nlos_burst_s = 0;       ///< mean length of a stretch of them; 0 = each by itself
  std::vector<double> outage_s;  ///< from to, from to ...: no ranges
  double dropped_share = 0;
  double max_distance_m = 1000;
  double max_solid_m = 1.0;  ///< through more of the scene's boxes nothing gets
  std::vector<double> jump;  ///< anchor's index, time [s], x y z: it is moved there
  /// Differences instead of ranges (TDoA): each anchor is heard together with the one before it, as
  /// by a robot that listens to anchors which are synchronised.
  bool differences = false;
  int seed = 1;
};
/// Section [SimulatedRanges].
void describe(OptionVisitor& v, RangeSimulationOptions& o);

struct SimulatedRange {
  TimeNs t = 0;
  int anchor = 0;      ///< id
  double range_m = 0;  ///< as measured; of a difference that to `anchor` less that to `reference`
  double true_m = 0;   ///< from the antenna to the anchor
  bool line_of_sight = true;
  std::optional<int> reference = std::nullopt;  ///< id; set: a difference
};

/// In time order. Every anchor answers `rate_hz` times a second at jittered times of its own. What
/// the boxes of `scene` (may be null) stand in the way of comes by another way, nlos_min_m to
/// nlos_max_m longer, or not at all. Throws std::invalid_argument for settings that make no sense
/// together (a list of the wrong length).
std::vector<SimulatedRange> simulateRanges(const Motion& motion,
                                           const RangeSimulationOptions& options,
                                           const rendering::Scene* scene = nullptr);

/// Differences of ranges (TDoA): each anchor against the one before it, the first against the last,
/// `rate_hz` times a second and pair; both errors are in it. As simulateRanges() otherwise; none
/// with fewer than two anchors.
std::vector<SimulatedRange> simulateRangeDifferences(const Motion& motion,
                                                     const RangeSimulationOptions& options,
                                                     const rendering::Scene* scene = nullptr);

/// Where anchor `index` is at a time [s after the motion's begin].
Vec3 anchorAt(const RangeSimulationOptions& options, std::size_t index, double s);

}  // namespace vir::simulation
