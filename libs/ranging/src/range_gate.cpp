#include "vir/ranging/range_gate.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "vir/core/order_statistics.h"

namespace vir::ranging {
namespace {

/// Quantile of the chi-square distribution of one degree of freedom that the median of the past is
/// compared with. The 75 % quantile instead of the 50 % one leaves room for a third of outliers.
constexpr double kExpectedMedian = 1.3233;
constexpr std::size_t kMostEntries = 4000;
/// A stamp this far back means another clock, not a late range.
constexpr TimeNs kClockStep = 1'000'000'000;

/// Never NaN, which no order holds: a median of such would not come to an end.
double squaredRatio(double residual, double sigma) {
  const double nis = residual * residual / (sigma * sigma);
  return std::isfinite(nis) ? nis : (residual / sigma) * (residual / sigma);
}

}  // namespace

RangeDecision RangeGate::check(TimeNs t, double residual_m, double variance_m2,
                               double travelled_m) {
  if (!std::isfinite(residual_m)) {
    ++counters_.invalid;
    return RangeDecision::invalid;
  }
  double sigma = std::sqrt(std::max(variance_m2, 0.0));
  if (!(sigma > 0)) sigma = options_.fallback_sigma_m;
  if (!entries_.empty() && t < entries_.back().t - kClockStep) reset();
  Entry entry{entries_.empty() ? t : std::max(t, entries_.back().t),
              residual_m,
              sigma,
              squaredRatio(residual_m, sigma),
              travelled_m,
              false};
  remember(entry);
  const bool blocked = allTooLong();
  const bool by_long_past = blocked && residual_m > 0;
  const double factor =
      widening(2 * (by_long_past ? options_.max_blocked_s : options_.max_reject_s));

  const double half_width = std::sqrt(options_.chi2) * sigma;
  const double most = blocked ? options_.max_widening_long : options_.max_widening;
  const double limit =
      std::min(factor * half_width, std::max(most * half_width, options_.min_offset_m));
  const bool accept = std::abs(residual_m) <= limit;
  entries_.back().rejected = !accept;
  updateSuspicion();
  if (!accept) {
    long& count = residual_m > 0 ? counters_.too_long : counters_.too_short;
    ++count;
    return residual_m > 0 ? RangeDecision::too_long : RangeDecision::too_short;
  }
  ++counters_.accepted;
  if (std::abs(residual_m) > half_width) ++counters_.widened;
  return RangeDecision::accepted;
}

void RangeGate::reset() {
  entries_.clear();
  suspicious_ = false;
}

void RangeGate::remember(const Entry& entry) {
  if (entries_.empty()) started_ = entry.t;
  entries_.push_back(entry);
  const TimeNs keep = fromSeconds(2 * std::max(options_.max_blocked_s, options_.max_reject_s));
  while (entries_.size() > kMostEntries || entries_.front().t < entry.t - keep) {
    entries_.pop_front();
  }
}

/// Factor on sigma that makes the median of the last `span_s` seconds probable. At least as much
/// past as the gate needs to call the anchor suspicious is asked for in number; what lies before
/// the first range counts as good, so that the gate does not open on the first few outliers.
double RangeGate::widening(double span_s) const {
  const TimeNs now = entries_.back().t;
  const TimeNs from = now - fromSeconds(span_s);
  std::vector<double> nis;
  for (auto it = entries_.rbegin(); it != entries_.rend() && it->t >= from; ++it) {
    nis.push_back(it->nis);
  }
  const double span = toSeconds(now - std::max(from, started_));
  const double covered = std::clamp(span / span_s, 0.05, 1.0);
  std::size_t wanted =
      std::max<std::size_t>(static_cast<std::size_t>(static_cast<double>(nis.size()) / covered),
                            static_cast<std::size_t>(options_.max_consecutive));
  nis.resize(std::max(nis.size(), wanted), 0.0);
  return std::max(1.0, std::sqrt(medianInPlace(&nis) / kExpectedMedian));
}

/// Over the last `span_s` seconds at least four in five were rejected: by the gate as it was then,
/// or by the gate as it would be without widening.
bool RangeGate::mostlyRejected(double span_s, bool by_decision) const {
  const TimeNs now = entries_.back().t;
  const TimeNs from = now - fromSeconds(span_s);
  if (entries_.front().t > from) return false;
  int count = 0, rejected = 0;
  for (auto it = entries_.rbegin(); it != entries_.rend() && it->t >= from; ++it) {
    ++count;
    if (by_decision ? it->rejected : it->nis > options_.chi2) ++rejected;
  }
  return count >= options_.max_consecutive && rejected >= 0.8 * count;
}

/// Is what disagrees in the recent past too long throughout, as without line of sight?
bool RangeGate::allTooLong() const {
  const TimeNs from = entries_.back().t - fromSeconds(2 * options_.max_reject_s);
  int too_long = 0, too_short = 0;
  for (auto it = entries_.rbegin(); it != entries_.rend() && it->t >= from; ++it) {
    if (it->nis <= options_.chi2) continue;
    ++(it->residual > 0 ? too_long : too_short);
  }
  return too_short <= 0.1 * (too_long + too_short);
}

void RangeGate::updateSuspicion() {
  suspicious_ = false;
  const double span = allTooLong() ? options_.max_blocked_s : options_.max_reject_s;
  if (!mostlyRejected(span, true) && !mostlyRejected(2 * span, false)) return;

  std::vector<double> size, step;
  double travelled = 0;
  bool moving = true;
  const Entry* later = nullptr;
  const TimeNs begin = entries_.back().t - fromSeconds(span);
  for (auto it = entries_.rbegin(); it != entries_.rend() && it->t >= begin; ++it) {
    size.push_back(std::abs(it->residual));
    if (later) step.push_back(std::abs(later->residual - it->residual));
    later = &*it;
    if (it->travelled < 0) continue;
    moving = false;
    travelled = entries_.back().travelled - it->travelled;
  }
  if (!moving && travelled < options_.min_travel_m) return;
  const double offset = medianInPlace(&size);
  if (offset < options_.min_offset_m) return;
  // A broken device jumps from range to range; a wrong position gives a smooth residual.
  suspicious_ = step.empty() || medianInPlace(&step) < 0.5 * offset;
}

}  // namespace vir::ranging
