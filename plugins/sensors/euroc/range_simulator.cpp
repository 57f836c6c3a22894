#include "range_simulator.h"

#include <algorithm>
#include <cmath>

#include "lever_arms.h"
#include "vir/geometry/interpolation.h"

namespace vir::euroc {
namespace {

constexpr double kJitter = 0.4;  // of the period, to either side

}  // namespace

RangeSimulator::RangeSimulator(const EurocOptions& o, std::unique_ptr<RowStream<PoseRow>> truth,
                               const Pose& T_B_I, ProblemLog* log)
    : options_(o),
      truth_(std::move(truth)),
      T_B_I_(T_B_I),
      log_(log),
      random_(static_cast<std::uint64_t>(o.range_seed)) {
  if (!truth_->peek()) return;
  before_ = after_ = *truth_->peek();
  truth_->pop();
  start_ = before_.t;
  for (std::size_t i = 0; i * 3 < o.anchor_m.size(); ++i) {
    Anchor a;
    a.id = o.anchor_id.empty() ? static_cast<int>(i) : static_cast<int>(o.anchor_id[i]);
    a.p_W = Vec3(o.anchor_m[3 * i], o.anchor_m[3 * i + 1], o.anchor_m[3 * i + 2]);
    anchors_.push_back(a);
    schedule(&anchors_.back());
  }
  advance();
}

void RangeSimulator::schedule(Anchor* a) {
  const double period = 1.0 / options_.range_rate_hz;
  const double jitter = kJitter * (2.0 * random_.uniform() - 1.0);
  // Half a period of offset: a negative jitter must not reach before the first pose.
  a->t = start_ + fromSeconds((static_cast<double>(a->slot) + 0.5 + jitter) * period);
  ++a->slot;
}

bool RangeSimulator::poseAt(TimeNs t, Pose* T_W_B) {
  while (after_.t < t) {
    if (!truth_->peek()) return false;
    before_ = after_;
    after_ = *truth_->peek();
    truth_->pop();
  }
  const TimeNs span = after_.t - before_.t;
  if (span <= 0) {
    *T_W_B = after_.T_W_B * T_B_I_;
    return true;
  }
  const double s = static_cast<double>(t - before_.t) / static_cast<double>(span);
  *T_W_B = interpolate(before_.T_W_B, after_.T_W_B, s) * T_B_I_;
  return true;
}

void RangeSimulator::advance() {
  has_next_ = false;
  if (anchors_.empty()) return;
  const Vec3 lever = leverArm(options_.lever_arm_m, 0);
  for (;;) {
    Anchor& a = *std::min_element(anchors_.begin(), anchors_.end(),
                                  [](const Anchor& x, const Anchor& y) { return x.t < y.t; });
    const TimeNs t = a.t;
    Pose T_W_B;
    if (!poseAt(t, &T_W_B)) return;
    // All four are drawn for every range, so that a change of one setting leaves the rest alone.
    const double noise = random_.normal();
    const bool nlos = random_.uniform() < options_.nlos_share;
    const double excess =
        options_.nlos_min_m + (options_.nlos_max_m - options_.nlos_min_m) * random_.uniform();
    schedule(&a);
    if (after_.t - before_.t > kMaxGap) {
      log_->count("range_in_ground_truth_gap");
      continue;
    }
    const double truth_m = (T_W_B * lever - a.p_W).norm();
    next_.t = t;
    next_.anchor = a.id;
    next_.line_of_sight = !nlos;
    next_.range_m = std::max(0.0, truth_m + options_.range_sigma_m * noise + (nlos ? excess : 0.0));
    has_next_ = true;
    return;
  }
}

}  // namespace vir::euroc
