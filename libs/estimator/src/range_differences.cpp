/// Differences of ranges (TDoA): checked, gated, held, and what a survey makes of them.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>

#include "range_layer_impl.h"
#include "vir/factors/range_factor.h"
#include "vir/ranging/survey_differences.h"

namespace vir::estimator {
namespace {

/// A survey is matched again when so many more differences have been heard: until it is found, and
/// to see whether it still fits.
constexpr double kMoreToFind = 1.15, kMoreToVerify = 1.6;
constexpr long kLeastMore = 20;
/// So many of anchors whose places nobody knows are worth a warning.
constexpr long kManyWithoutPlace = 100;
constexpr std::size_t kMostPairs = 4096;  // a broken stream of ids must not fill the memory

AnchorPair pairOf(const Range& r) { return {*r.reference, r.anchor}; }

/// Generation 0 or later: the id that a key of the window stands for.
std::uint64_t idOf(std::uint64_t key) { return key & ((1ull << 48) - 1); }

}  // namespace

RangeDecision RangeLayer::Impl::checkDifference(const Range& range) {
  if (range.anchor == *range.reference) return RangeDecision::bad_id;
  Antenna& antenna = antennaAt(range.p_B_U);
  const AnchorPair pair = pairOf(range);
  auto at = antenna.of_differences.find(pair);
  if (at == antenna.of_differences.end()) {
    if (antenna.of_differences.size() >= kMostPairs) return RangeDecision::too_many_anchors;
    ranging::RangeCheckOptions o = checkOptions(options);
    o.either_sign = true;
    at = antenna.of_differences.emplace(pair, ranging::RangeCheck(o)).first;
  }
  return at->second.check(0, range.t, range.range_m);
}

RangeLayer::Impl::Innovation RangeLayer::Impl::differenceInnovation(
    const window::HeldRange& held, const AntennaPrediction& antenna) const {
  const std::uint64_t keys[2] = {held.anchor, *held.reference};
  Vec3 direction = Vec3::Zero();
  double predicted = 0, sign = 1;
  const Vec3 arm = antenna.p_W - window->head().position();
  // Head of the long window, then both anchors.
  Eigen::Matrix<double, 13, 1> h = Eigen::Matrix<double, 13, 1>::Zero();
  int columns[2] = {-1, -1};
  for (int i = 0; i < 2; ++i, sign = -1) {
    const window::AnchorNode& state = *window->anchor(keys[i]);
    const factors::RangePrediction p =
        factors::predictRange(antenna.p_W, state.position(), state.x[3], 0);
    predicted += sign * p.value_m;
    direction += sign * p.direction;
    h.segment<3>(5 + 4 * i) = -sign * p.direction;
    h[8 + 4 * i] = sign;
    columns[i] = window->columnOf(keys[i]);
  }
  double variance =
      held.sigma_m * held.sigma_m + direction.dot(antenna.inner_covariance * direction);
  h.head<3>() = direction;
  h[3] = direction.dot(Vec3(-arm.y(), arm.x(), 0));
  if (columns[0] >= 0 && columns[1] >= 0) {
    const Eigen::MatrixXd& J = window->jointCovariance();
    const int from[3] = {0, columns[0], columns[1]}, size[3] = {5, 4, 4}, to[3] = {0, 5, 9};
    Eigen::Matrix<double, 13, 13> P;
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 3; ++k) {
        P.block(to[i], to[k], size[i], size[k]) = J.block(from[i], from[k], size[i], size[k]);
      }
    }
    variance += std::max(0.0, h.dot(P * h));
  }
  return {held.range_m - predicted, variance};
}

bool RangeLayer::Impl::acceptDifference(const Range& range, const AntennaPrediction& antenna,
                                        window::HeldRange* held) {
  travelTo(antenna.p_W);
  const AnchorTrack &a = track(range.anchor), &reference = track(*range.reference);
  held->t = range.t;
  held->anchor = a.key();
  held->reference = reference.key();
  held->range_m = range.range_m;
  held->sigma_m = sigmaOf(range);
  held->merged = 1;
  auto at = differences.find(pairOf(range));
  if (at == differences.end()) {
    DifferenceTrack fresh;
    fresh.gate = ranging::RangeGate(gateOptions());
    at = differences.emplace(pairOf(range), std::move(fresh)).first;
  }
  DifferenceTrack& d = at->second;
  if (window->anchor(a.key()) == nullptr || window->anchor(reference.key()) == nullptr) {
    record(range, RangeDecision::collected);
    ++d.collected;
    return true;
  }
  const auto [residual, variance] = differenceInnovation(*held, antenna);
  RangeRecord r = recordOf(range, residual, variance);
  r.decision = d.gate.check(range.t, residual, variance, travelled_m);
  const bool accepted = r.decision == RangeDecision::accepted;
  const factors::RangeTerm term = window->termOf(a.key(), held->range_m, held->sigma_m);
  r.weight = accepted ? term.robust.evaluate(-std::abs(residual) / term.sigma_m).weight : 0;
  decisions.push_back(r);
  ++(accepted ? d.used : d.rejected);
  // Without a factor, but a survey is judged by all of them.
  if (!accepted) held->anchor = a.doubtedKey();
  return r.decision != RangeDecision::invalid;
}

bool RangeLayer::Impl::updateSurveyByDifferences(TimeNs t, const HeldDifferences& held) {
  long heard = 0;
  bool suspicious = false;
  for (const auto& [pair, d] : differences) {
    if (!isSurveyed(pair.first) || !isSurveyed(pair.second)) continue;
    heard += d.heard();
    suspicious = suspicious || d.gate.suspicious();
  }
  const double more = survey.found && !suspicious ? kMoreToVerify : kMoreToFind;
  const bool due =
      static_cast<double>(heard) > more * static_cast<double>(survey.matched_with) + kLeastMore;
  if (!due) return survey.found && placeNewlyHeard(t);
  survey.matched_with = heard;
  std::vector<window::HeldRange> all = held();
  std::stable_sort(all.begin(), all.end(), [](const auto& x, const auto& y) { return x.t < y.t; });
  const auto indexOf = [this](std::uint64_t key) {
    const auto at = std::find_if(survey.given.begin(), survey.given.end(),
                                 [&](const SurveyedAnchor& s) { return s.id == idOf(key); });
    return static_cast<std::size_t>(at - survey.given.begin());
  };
  std::vector<ranging::SurveyDifference> list;
  for (const window::HeldRange& r : all) {
    const std::size_t anchor = indexOf(r.anchor), reference = indexOf(*r.reference);
    if (anchor >= survey.given.size() || reference >= survey.given.size()) continue;
    list.push_back({anchor, reference, r.motion, r.range_m, r.sigma_m});
  }
  ranging::SurveyMatchOptions o;
  o.min_ranges = options.min_ranges;
  o.bias_sigma_m = biasSigma(false);
  o.drift_ratio = options.drift_ratio;
  o.max_sigma_m = options.max_anchor_sigma_m;
  ranging::SurveyMatch match = ranging::matchSurveyByDifferences(list, survey.given, o);
  const bool changes = match.status == SurveyStatus::found ||
                       (survey.found && match.status == SurveyStatus::contradicted);
  if (!changes && survey.found) return placeNewlyHeard(t);
  takeMatch(t, std::move(match));
  return changes;
}

/// Once: nothing is found from differences alone, and silence would look like success.
void RangeLayer::Impl::warnOfDifferencesWithoutPlaces() {
  if (differences_warned) return;
  long collected = 0;
  std::string ids;
  for (const auto& [id, a] : tracks) {
    long of_anchor = 0;
    for (const auto& [pair, d] : differences) {
      if (pair.first == id || pair.second == id) of_anchor += d.collected;
    }
    const bool ranged = a.collected + a.used + a.rejected > 0;
    if (of_anchor == 0 || ranged || a.prior || a.located() != nullptr || isSurveyed(id)) continue;
    collected += of_anchor;
    ids += (ids.empty() ? "" : ", ") + std::to_string(id);
  }
  if (collected < kManyWithoutPlace) return;
  differences_warned = true;
  warn("differences of ranges (TDoA) to anchors whose places nobody knows (" + ids +
       ") are not used: differences alone do not tell where anchors are; measure them and give the "
       "table, --anchors anchors.csv (id,x,y,z,sigma)");
}

}  // namespace vir::estimator
