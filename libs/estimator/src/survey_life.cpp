/// A survey of the anchors: how it lies in W, and who is held to it.
#include "survey_life.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>

#include "range_layer_impl.h"

namespace vir::estimator {
namespace {

/// A survey is matched again when so many more ranges have been heard: while it is not found, while
/// it is not settled, and to see whether it still fits.
constexpr double kMoreToFind = 1.1, kMoreToSettle = 1.3, kMoreToVerify = 1.6;
constexpr long kLeastMore = 10;
/// An anchor that is farther from where the survey has it goes there: sigmas, and [m].
constexpr double kFarSigmas = 3, kFar = 0.1;
/// What the path's drift may have done to where an anchor is in W since the match [m].
constexpr double kDrifted = 0.1;
/// How far the biases of uncalibrated boards are from being all alike [m].
constexpr double kOddBoards = 0.2;
/// Nothing is known of an anchor but its ranges and its ties [m].
constexpr double kAnywhere = 1000;

/// One that is only left out may be hidden for a while: the gate is there for that.
bool isFoundElsewhere(const ranging::SurveyMatch& match, std::size_t anchor) {
  return std::any_of(match.findings.begin(), match.findings.end(),
                     [&](const ranging::SurveyFinding& f) {
                       return f.fault == ranging::SurveyFault::elsewhere && f.first == anchor;
                     });
}

double longestAxis(const Mat3& covariance) {
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(covariance);
  return std::sqrt(std::max(0.0, eigen.eigenvalues()[2]));
}

}  // namespace

bool RangeLayer::Impl::isSurveyed(std::uint64_t id) const {
  return std::any_of(survey.given.begin(), survey.given.end(),
                     [&](const SurveyedAnchor& s) { return s.id == id; });
}

std::vector<window::HeldRange> RangeLayer::Impl::allHeld(const AnchorTrack& a,
                                                         const Held& held) const {
  std::vector<window::HeldRange> out = held(a.key());
  if (!isSurveyed(a.id)) return out;
  for (const window::HeldRange& r : held(a.doubtedKey())) out.push_back(r);
  std::stable_sort(out.begin(), out.end(), [](const auto& x, const auto& y) { return x.t < y.t; });
  return out;
}

std::vector<ranging::SurveyRange> RangeLayer::Impl::surveyRanges(const Held& held) const {
  std::vector<std::pair<TimeNs, ranging::SurveyRange>> all;
  for (std::size_t i = 0; i < survey.given.size(); ++i) {
    const auto at = tracks.find(survey.given[i].id);
    if (at == tracks.end() || at->second.left_survey) continue;
    for (const window::HeldRange& r : allHeld(at->second, held)) {
      all.push_back({r.t, {i, r.motion, r.range_m, r.sigma_m}});
    }
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<ranging::SurveyRange> out;
  for (const auto& [t, r] : all) out.push_back(r);
  return out;
}

bool RangeLayer::Impl::updateSurvey(TimeNs t, const Held& held, const HeldDifferences& of_ranges) {
  warnOfDifferencesWithoutPlaces();
  if (survey.given.empty()) return false;
  long heard = 0;
  bool suspicious = false;
  for (const SurveyedAnchor& s : survey.given) {
    const auto at = tracks.find(s.id);
    if (at != tracks.end()) {
      heard += at->second.used + at->second.rejected + at->second.collected;
      suspicious = suspicious || (at->second.tied && at->second.gate.suspicious());
    }
  }
  if (heard == 0) return updateSurveyByDifferences(t, of_ranges);
  const bool settled = survey.match.needed_sigma_m < kSettledSigma && !survey.match.other;
  const double more = !survey.found            ? kMoreToFind
                      : settled && !suspicious ? kMoreToVerify
                                               : kMoreToSettle;
  const bool due =
      static_cast<double>(heard) > more * static_cast<double>(survey.matched_with) + kLeastMore;
  if (!due) return survey.found && placeNewlyHeard(t);
  survey.matched_with = heard;
  ranging::SurveyMatchOptions o;
  o.min_ranges = options.min_ranges;
  o.bias_sigma_m = biasSigma(false);
  o.uncalibrated_bias_sigma_m = mayBeUncalibrated() ? biasSigma(true) : 0;
  o.drift_ratio = options.drift_ratio;
  o.scale_sigma = options.path_scale_sigma;
  o.max_sigma_m = options.max_anchor_sigma_m;
  o.correlation = options.correlation;
  o.thorough = !survey.found;
  ranging::SurveyMatch match = matchAgain(surveyRanges(held), o);
  const bool changes = match.status == SurveyStatus::found ||
                       (survey.found && match.status == SurveyStatus::contradicted);
  if (!changes && survey.found) return placeNewlyHeard(t);
  takeMatch(t, std::move(match));
  return changes;
}

/// What has been found to be wrong stays so while the rest fits.
ranging::SurveyMatch RangeLayer::Impl::matchAgain(std::vector<ranging::SurveyRange> ranges,
                                                  const ranging::SurveyMatchOptions& o) const {
  const ranging::SurveyMatch& before = survey.match;
  if (!survey.found || before.findings.empty()) {
    return ranging::matchSurvey(ranges, survey.given, o);
  }
  const std::vector<ranging::SurveyRange> all = ranges;
  ranges.erase(std::remove_if(ranges.begin(), ranges.end(),
                              [&](const auto& r) { return !before.anchors[r.anchor].used; }),
               ranges.end());
  ranging::SurveyMatch match = ranging::matchSurvey(ranges, before.survey, o);
  if (match.status != SurveyStatus::found || !match.findings.empty()) {
    return ranging::matchSurvey(all, survey.given, o);
  }
  match.findings = before.findings;
  for (std::size_t i = 0; i < match.anchors.size(); ++i) {
    match.anchors[i].used = match.anchors[i].used && before.anchors[i].used;
  }
  return match;
}

void RangeLayer::Impl::takeMatch(TimeNs t, ranging::SurveyMatch match) {
  const bool before = survey.found;
  survey.match = std::move(match);
  survey.found = survey.match.status == SurveyStatus::found;
  for (const ranging::SurveyFinding& f : survey.match.findings) {
    const std::string text = ranging::describe(f, survey.given);
    if (std::find(survey.told.begin(), survey.told.end(), text) != survey.told.end()) continue;
    survey.told.push_back(text);
    log(log_sink, LogLevel::info, text);
  }
  if (survey.found != before) {
    log(log_sink, LogLevel::info,
        survey.found ? "the survey of the anchors is found in the path's world, " +
                           std::to_string(toSeconds(t)) + " s"
                     : "the survey of the anchors is given up: " + survey.match.reason);
  }
  for (std::size_t i = 0; i < survey.given.size(); ++i) {
    const auto at = tracks.find(survey.given[i].id);
    if (at == tracks.end()) continue;
    AnchorTrack& a = at->second;
    if (!survey.found) {
      a.tied = false;
    } else if (survey.match.anchors[i].used && !a.left_survey) {
      tie(t, &a, survey.match.anchors[i], survey.match.survey[i]);
    } else if (a.tied && isFoundElsewhere(survey.match, i)) {
      untie(t, &a);
    }
  }
  setTies();
}

/// Where it is and how it is held is the survey's business from here on; its bias remains its own.
void RangeLayer::Impl::tie(TimeNs t, AnchorTrack* a, const ranging::MatchedAnchor& m,
                           const SurveyedAnchor& given) {
  const Mat3 where = m.covariance.topLeftCorner<3, 3>();
  ranging::AnchorPrior prior;
  prior.p_W = m.p_W;
  prior.covariance =
      where + (given.sigma_m * given.sigma_m + kDrifted * kDrifted) * Mat3::Identity();
  a->prior = prior;
  a->tied = true;
  a->advice.clear();
  const bool young = survey.match.needed_sigma_m >= kSettledSigma;
  if (Located* located = a->located()) {
    window::AnchorNode& state = *window->anchor(a->key());
    const double off = (state.position() - m.p_W).norm();
    if (off > std::max(kFar, kFarSigmas * longestAxis(where))) {
      moveTo(t, a, located, m.p_W);
      state.x[3] = m.bias_m;
    }
    if (!young) endYouth(*a, located);
    located->mirror = MirrorRuledOut{};
    located->well_known = located->well_known || !young;
    return;
  }
  a->uncalibrated = survey.match.uncalibrated;
  Eigen::Matrix4d covariance = kAnywhere * kAnywhere * Eigen::Matrix4d::Identity();
  covariance(3, 3) = biasSigma(a->uncalibrated) * biasSigma(a->uncalibrated);
  Eigen::Vector4d mean;
  mean << m.p_W, 0;
  window::AnchorNode& state = window->addAnchor(a->key(), mean, covariance);
  state.x[3] = m.bias_m;
  Located located;
  located.found_at = t;
  located.well_known = !young;
  if (young) located.youth = Youth{m.covariance, 0};
  located.mirror = MirrorRuledOut{};
  state.settled = !young;
  a->state = located;
  a->gate.reset();
}

/// It has been where the survey has it, and is elsewhere now; or it has never been there, and where
/// it has been held says nothing.
void RangeLayer::Impl::untie(TimeNs t, AnchorTrack* a) {
  if (trusted(*a, a->located() != nullptr && a->located()->well_known)) {
    giveUp(t, a, true);
    return;
  }
  window->removeAnchor(a->key());
  a->state = Collecting{};
  a->tied = false;
  a->prior.reset();
  a->gate.reset();
}

void RangeLayer::Impl::setTies() {
  std::vector<window::SurveyTie> ties;
  for (std::size_t i = 0; i < survey.given.size(); ++i) {
    const auto at = tracks.find(survey.given[i].id);
    if (at == tracks.end() || !at->second.tied) continue;
    const SurveyedAnchor& s = survey.match.survey[i];
    ties.push_back({at->second.key(), s.p_S, s.sigma_m});
  }
  window->setSurvey(std::move(ties));
}

void RangeLayer::Impl::setDistances() {
  if (distances.pairs().empty()) return;
  std::vector<window::AnchorDistance> out;
  for (const AnchorDistances::Pair& pair : distances.pairs()) {
    const auto a = tracks.find(pair.first), b = tracks.find(pair.second);
    if (a == tracks.end() || b == tracks.end()) continue;
    const Located *first = a->second.located(), *second = b->second.located();
    const auto d = distances.of(pair);
    if (first == nullptr || second == nullptr || !d) continue;
    // Between two anchors their boards' delays add up as between each of them and the robot's, if
    // all are of one kind: half of either bias.
    const double bias =
        0.5 * (window->anchor(a->second.key())->x[3] + window->anchor(b->second.key())->x[3]);
    const bool odd = a->second.uncalibrated || b->second.uncalibrated;
    const bool open = mayBeUncalibrated() && !odd && !(first->bias_known && second->bias_known);
    const double of_bias = open  ? biasSigma(true)
                           : odd ? std::max(kOddBoards, biasSigma(false))
                                 : std::sqrt(2.0) * biasSigma(false);
    out.push_back(
        {a->second.key(), b->second.key(), d->range_m - bias, std::hypot(d->sigma_m, of_bias)});
  }
  window->setAnchorDistances(std::move(out));
}

/// An anchor that comes into range later: the others say where it is.
bool RangeLayer::Impl::placeNewlyHeard(TimeNs t) {
  bool placed = false;
  for (std::size_t i = 0; i < survey.given.size(); ++i) {
    const auto at = tracks.find(survey.given[i].id);
    if (at == tracks.end() || !survey.match.anchors[i].used) continue;
    AnchorTrack& a = at->second;
    if (a.tied || a.left_survey || a.collecting() == nullptr) continue;
    ranging::MatchedAnchor m = survey.match.anchors[i];
    m.p_W = window->surveyFit().T_A_B.inverse() * survey.match.survey[i].p_S;
    m.bias_m = 0;
    m.covariance.topLeftCorner<3, 3>() += kDrifted * kDrifted * Mat3::Identity();
    tie(t, &a, m, survey.match.survey[i]);
    placed = true;
  }
  if (placed) setTies();
  return placed;
}

}  // namespace vir::estimator
