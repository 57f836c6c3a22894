/// The settings of this library as the ini has them.
#include "vir/core/options.h"
#include "vir/ranging/anchor_initialization.h"
#include "vir/ranging/range_check.h"
#include "vir/ranging/range_gate.h"
#include "vir/ranging/robust_range.h"

namespace vir {

void describe(OptionVisitor& v, RobustRange& o) {
  v.section("Ranges", "How ranges are judged");
  v.value("huber_delta", o.huber_delta, {0.0, 1e6},
          "sigmas at which a range that is too short starts to count less; 0 = never");
  v.value("nlos_delta", o.nlos_delta, {0.0, 1e6},
          "the same for one that is too long, as without line of sight");
}

void describe(OptionVisitor& v, RangeCheckOptions& o) {
  v.section("Ranges", "How ranges are judged");
  v.value("max_range_m", o.max_range_m, {0.1, 1e6}, "longer ones are absurd and dropped");
  v.value("max_equal", o.max_equal, {2, 1000000},
          "so many times the same value in a row: the device is stuck");
}

void describe(OptionVisitor& v, GateOptions& o) {
  v.section("Ranges", "How ranges are judged");
  v.value("gate_chi2", o.chi2, {1.0, 1e6}, "chi-square of one degree of freedom that may pass");
  v.value("gate_max_reject_s", o.max_reject_s, {0.1, 1e4},
          "time of rejecting nearly all before the anchor is suspected to have moved");
  v.value("gate_max_too_long_s", o.max_too_long_s, {0.1, 1e4},
          "the same where all are too long: that may be an obstacle");
  v.value("gate_max_consecutive", o.max_consecutive, {2, 100000},
          "and at least so many ranges in that time");
  v.value("gate_min_travel_m", o.min_travel_m, {0.0, 1e4},
          "and at least so much motion in that time");
  v.value("gate_min_offset_m", o.min_offset_m, {0.0, 1e4},
          "an anchor that moved by less is not started anew");
  v.value("gate_max_widening", o.max_widening, {1.0, 1e3},
          "by how much the gate may widen when the covariance proves too small");
}

void describe(OptionVisitor& v, AnchorInitOptions& o) {
  v.section("AnchorInit", "When and how the position of an unknown anchor is found");
  v.value("min_ranges", o.min_ranges, {4, 100000}, "ranges before the first try");
  v.value("min_extent_m", o.min_extent_m, {0.0, 1e4}, "length of the path before the first try");
  v.value("bias_sigma_m", o.bias_sigma_m, {0.0, 100.0},
          "standard deviation of an anchor's constant bias; 0 = there is none");
  v.value("drift_ratio", o.drift_ratio, {0.0, 1.0}, "drift of the path, metre per metre");
  v.value("max_sigma_m", o.max_sigma_m, {1e-3, 1e4},
          "how well two of three directions must be known");
  v.value("mirror_chi2", o.mirror_chi2, {1.0, 1e4},
          "a second solution worse by more than this is rejected");
  v.value("max_rms_ratio", o.max_rms_ratio, {1.0, 1e4},
          "residuals of so many sigmas do not fit one position");
}

}  // namespace vir
