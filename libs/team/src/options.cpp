#include "vir/core/options.h"

#include "vir/core/option_check.h"
#include "vir/team/find_transform.h"

namespace vir::team {

void TransformOptions::validate() const { checkBounds(*this); }

void describe(OptionVisitor& v, TransformOptions& o) {
  v.section("Rendezvous", "How the transform between two robots' worlds is found");
  v.value("false_alarm", o.false_alarm, {1e-12, 0.5},
          "rate at which a wrong solution may be called unique");
  v.value("min_ranges_without_anchor", o.min_ranges_without_anchor, {5, 1000},
          "mutual ranges before the first try without a common anchor");
  v.value("max_yaw_sigma_rad", o.max_yaw_sigma_rad, {1e-4, 3.0},
          "with a larger standard deviation of the yaw nothing is said");
  v.value("max_sigma_m", o.max_sigma_m, {1e-4, 1e3},
          "the same for where the other robot's path lies, horizontally");
  v.value("same_solution_m", o.same_solution_m, {1e-4, 1e3},
          "solutions that place the other robot's path closer than this are one");
  v.value("slow_share", o.slow_share, {0.0, 100.0},
          "slow error of a range as a share of its sigma (multipath changes slowly)");
  v.value("slow_time_s", o.slow_time_s, {1e-3, 1e5}, "time in which that error changes");
  v.value("position_time_s", o.position_time_s, {1e-3, 1e6},
          "time in which the errors of estimated positions change");
  v.value("drift_m_per_sqrt_s", o.drift_m_per_sqrt_s, {0.0, 10.0},
          "how the two worlds slide against each other beside what the positions' covariances say; "
          "makes recent ranges count more [m/sqrt(s)]");
  v.value("drift_rad_per_sqrt_s", o.drift_rad_per_sqrt_s, {0.0, 1.0},
          "how they turn against each other [rad/sqrt(s)]");
  v.value("gate_sigma", o.gate_sigma, {1.0, 100.0}, "a range farther off counts as rejected");
  v.value("min_inlier_share", o.min_inlier_share, {0.1, 1.0},
          "with a smaller share of ranges that fit, the answer is `inconsistent`");
  v.value("max_short_share", o.max_short_share, {0.0, 1.0},
          "the same for ranges that are too short: no obstacle explains these");
  v.value("anchor_chi2", o.anchor_chi2, {1.0, 1e6},
          "squared sigmas beyond which a common anchor is taken as wrong");
  v.value("places_chi2", o.places_chi2, {1.0, 1e6},
          "the same for places that both robots' images show: beyond, they only look alike");
  v.value("max_search_ranges", o.max_search_ranges, {10, 100000},
          "of all ranges, so many are used for finding where to start");
  v.value("max_global_evaluations", o.max_global_evaluations, {30, 10000000},
          "of the global search, where closed forms give nothing to start from");
  v.value("polish_evaluations", o.polish_evaluations, {6, 1000000},
          "of the last refinement (NLopt BOBYQA)");
  v.value("max_polish_ranges", o.max_polish_ranges, {0, 1000000},
          "with more ranges than this it is left out: it gains less than it takes");
  v.value("huber_delta", o.robust.huber_delta, {0.0, 1e6},
          "sigmas at which a range that is too short starts to count less; 0 = never");
  v.value("nlos_delta", o.robust.nlos_delta, {0.0, 1e6},
          "the same for one that is too long, as without line of sight");
}

const char* name(TransformStatus status) {
  switch (status) {
    case TransformStatus::unique:
      return "unique";
    case TransformStatus::ambiguous:
      return "ambiguous";
    case TransformStatus::degenerate:
      return "degenerate";
    case TransformStatus::inconsistent:
      break;
  }
  return "inconsistent";
}

}  // namespace vir::team
