/// Is an anchor's board calibrated?
#include <algorithm>
#include <cmath>
#include <utility>

#include "range_layer_impl.h"

namespace vir::estimator {
namespace {

/// A bias of so many standard deviations is real; one known to so many calibrated sigmas is known.
constexpr double kRealBias = 4, kToldBias = 2, kBiasKnown = 1;
/// Keyframes between two searches: so many, and where the window holds more, this share of it. What
/// it holds is searched, and a search in nearly the same ranges says nearly the same.
constexpr int kBiasPeriod = 10;
constexpr double kBiasShare = 0.1;

/// Beyond what a calibrated board can have and chance can make.
bool biasIsReal(const ranging::AnchorInitialization& found, double calibrated_sigma) {
  const ranging::AnchorSolution& best = found.solutions.front();
  // Boards as they come read too long: less proof will do for that.
  const double proof = best.bias_m > 0 ? kToldBias : kRealBias;
  return std::abs(best.bias_m) > proof * std::sqrt(best.covariance(3, 3)) &&
         std::abs(best.bias_m) > kRealBias * calibrated_sigma;
}

/// -2 log of the likelihood ratio of two kinds of boards that takes back what was said.
constexpr double kCalibratedAfterAll = 2;

/// Is a bias that was estimated as an uncalibrated board's rather that of a calibrated one?
bool looksCalibrated(double bias_m, double variance, double calibrated_sigma,
                     double uncalibrated_sigma) {
  const auto cost = [&](double sigma) {
    const double all = variance + sigma * sigma;
    return bias_m * bias_m / all + std::log(all);
  };
  return cost(uncalibrated_sigma) - cost(calibrated_sigma) > kCalibratedAfterAll;
}

}  // namespace

ranging::AnchorInitialization RangeLayer::Impl::solveEitherWay(
    AnchorTrack* a, const std::vector<window::HeldRange>& held) const {
  ranging::AnchorInitialization calibrated = solve(*a, held, false);
  if (!mayBeUncalibrated()) return calibrated;
  ranging::AnchorInitialization free = solve(*a, held, true);
  a->uncalibrated =
      isUsable(free) && (biasIsReal(free, options.bias_sigma_m) ||
                         calibrated.geometry == ranging::AnchorGeometry::inconsistent);
  return a->uncalibrated ? free : calibrated;
}

void RangeLayer::Impl::searchForBias(const AnchorTrack& a, Located* located,
                                     const Held& held) const {
  located->bias_due = false;
  located->bias_search = solve(a, held(a.key()), true);
}

/// A board that came as it is reads half a metre too long. Held to the bias of a calibrated one,
/// its ranges bend the path and move the anchor until they fit, and the window's own linearisation
/// sees no way back. So the held ranges are asked now and then, until they have said what it is: in
/// the image after the keyframe, which has the time, for the next keyframe to act on.
bool RangeLayer::Impl::decideBias(TimeNs t, AnchorTrack* a, Located* located, const Held& held) {
  if (located->bias_known || (a->uncalibrated && a->tied)) return false;
  window::AnchorNode& state = *window->anchor(a->key());
  if (state.fixed || !mayBeUncalibrated()) return false;
  if (located->bias_due) searchForBias(*a, located, held);
  if (!located->bias_search) {
    if (--located->next_bias_check > 0) return false;
    const auto held_nodes = static_cast<double>(window->nodes().size());
    located->next_bias_check = std::max(kBiasPeriod, static_cast<int>(kBiasShare * held_nodes));
    located->bias_due = true;
    if (spreads_work) return false;
    searchForBias(*a, located, held);
  }
  const ranging::AnchorInitialization found = *std::exchange(located->bias_search, std::nullopt);
  if (!isUsable(found)) return false;
  const ranging::AnchorSolution& best = found.solutions.front();
  const bool known = std::sqrt(best.covariance(3, 3)) < kBiasKnown * options.bias_sigma_m;
  const bool real = biasIsReal(found, options.bias_sigma_m);
  if (!real || a->uncalibrated) {
    located->bias_known = known;
    if (!real && a->uncalibrated) reconsider(t, a, &state);
    return false;
  }
  a->uncalibrated = a->told_uncalibrated = true;
  state.prior_information(3, 3) = 1 / (biasSigma(true) * biasSigma(true));
  state.x[3] = best.bias_m;
  warn("anchor " + std::to_string(a->id) + " at " + elapsed.text(t) + ": its ranges are " +
       std::to_string(std::abs(best.bias_m)).substr(0, 4) + " m too " +
       (best.bias_m > 0 ? "long" : "short") + ": an uncalibrated board; the bias is estimated");
  moveTo(t, a, located, best.p_W);
  return true;
}

/// What the first ranges said, as from behind an obstacle, the later ones need not. The window
/// knows the bias better than a fresh search does, whose path is free to bend.
void RangeLayer::Impl::reconsider(TimeNs t, AnchorTrack* a, window::AnchorNode* state) {
  const int column = window->columnOf(a->key());
  if (column < 0) return;
  const double variance = window->jointCovariance()(column + 3, column + 3);
  if (!looksCalibrated(state->x[3], variance, biasSigma(false), biasSigma(true))) return;
  a->uncalibrated = false;
  state->prior_information(3, 3) = 1 / (biasSigma(false) * biasSigma(false));
  if (!std::exchange(a->told_uncalibrated, false)) return;
  warn("anchor " + std::to_string(a->id) + " at " + elapsed.text(t) +
       ": its ranges are right after all: its board is a calibrated one");
}

void RangeLayer::betweenKeyframes(const Held& held) {
  impl_->spreads_work = true;
  for (auto& [id, a] : impl_->tracks) {
    Located* located = a.located();
    if (located == nullptr || !located->bias_due) continue;
    impl_->searchForBias(a, located, held);
    return;
  }
}

}  // namespace vir::estimator
