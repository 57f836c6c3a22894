/// How anchors are found, watched, moved to where they fit better, and given up.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "mirror.h"
#include "range_layer_impl.h"
#include "vir/core/angles.h"
#include "vir/ranging/range_correlation.h"

namespace vir::estimator {
namespace {

/// Keyframes between two looks at an open mirror image, and between two estimates of correlation.
constexpr int kMirrorPeriod = 15, kOpenMirrorPeriod = 3;
constexpr int kCorrelationPeriod = 10;
/// Twice the difference in loss between the mirror image and the present position that closes the
/// question, and that decides against the present one.
constexpr double kMirrorClosed = 30, kMirrorSwitch = 2;
/// An anchor has settled after so long [s], if not before; until then a search every few keyframes.
constexpr double kLongestYouthS = 30;
constexpr int kSearchPeriod = 3;
/// Nearer to the floor than this share of its sigma, a height starts so many sigmas above it.
constexpr double kOnTheFloor = 0.25, kLift = 0.5;
/// Farther from where the long window's own solution ends [m], a young anchor is stuck.
constexpr double kStuck = 0.1;
/// Share of ranges an anchor must have explained before a contradiction means that it was moved;
/// below, its start was wrong.
constexpr double kTrusted = 0.7;
/// What a range is worth that may come from anywhere: density 1 / 20 m. One in ten ranges is such.
const double kAnywhere = std::log(1.0 / 20), kOutlierShare = 0.1;
/// Successive ranges err together: so many count as one. Evidence (log of the likelihood ratio)
/// that takes an anchor back to its former position.
constexpr double kRangesPerEvidence = 10, kFormerEvidence = 20;
/// Span of the mean taken off residuals before their correlation is estimated [s].
constexpr double kSlowPartS = 6.0;
/// A claimed sigma may turn out too large; its square is not cut below this share.
constexpr double kLeastFactor = 0.2;

std::string text(const Vec3& p) {
  char out[80];
  std::snprintf(out, sizeof out, "(%.2f, %.2f, %.2f)", p.x(), p.y(), p.z());
  return out;
}

/// Of an innovation [m] with its variance.
double logLikelihood(double residual, double innovation_variance) {
  const double variance = std::max(innovation_variance, 1e-8);
  const double density =
      std::exp(-0.5 * residual * residual / variance) / std::sqrt(2 * kPi * variance);
  return std::log((1 - kOutlierShare) * density + kOutlierShare * std::exp(kAnywhere));
}

/// Level with the path the height is at a saddle that no iteration of the window leaves: whichever
/// side it begins on, it can then move.
double liftOff(const ranging::AnchorSolution& s, double floor_z) {
  const double sigma = std::sqrt(std::max(0.0, s.covariance(2, 2)));
  return std::abs(s.p_W.z() - floor_z) < kOnTheFloor * sigma ? kLift * sigma : 0;
}

}  // namespace

ranging::AnchorInitialization RangeLayer::Impl::solve(const AnchorTrack& a,
                                                      const std::vector<window::HeldRange>& held,
                                                      bool uncalibrated) const {
  std::vector<ranging::AntennaRange> samples;
  samples.reserve(held.size());
  for (const window::HeldRange& r : held) samples.push_back({r.motion, r.range_m, r.sigma_m});
  ranging::AnchorInitOptions o;
  o.min_ranges = options.min_ranges;
  o.bias_sigma_m = biasSigma(uncalibrated);
  o.max_sigma_m = options.max_anchor_sigma_m;
  o.floor_sigma_m = options.floor_sigma_m;
  o.drift_ratio = options.drift_ratio;
  o.scale_sigma = options.path_scale_sigma;
  o.correlation = options.correlation;
  return ranging::initializeAnchor(samples, o, a.prior);
}

void RangeLayer::Impl::adopt(TimeNs t, AnchorTrack* a, const ranging::AnchorInitialization& found) {
  const ranging::AnchorSolution& best = found.solutions.front();
  // The ranges themselves stay factors of the window: the start's covariance must not count too.
  const double far = 20 + best.p_W.norm();
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Identity() * far * far;
  covariance(3, 3) = biasSigma(a->uncalibrated) * biasSigma(a->uncalibrated);
  Eigen::Vector4d mean;
  mean << best.p_W, 0;
  const std::optional<ranging::AnchorPrior>& prior = a->prior ? a->prior : found.floor;
  if (prior) {
    covariance.topLeftCorner<3, 3>() = prior->covariance;
    mean.head<3>() = prior->p_W;
  }
  window::AnchorNode& state = window->addAnchor(a->key(), mean, covariance);
  for (int i = 0; i < 3; ++i) state.x[i] = best.p_W[i];
  state.x[3] = best.bias_m;
  if (found.floor) state.x[2] += liftOff(best, found.floor->p_W.z());
  Located located;
  located.found_at = t;
  located.well_known = found.needed_sigma_m < kSettledSigma;
  if (!located.well_known) located.youth = Youth{best.covariance, kSearchPeriod};
  if (found.solutions.size() > 1) located.mirror = MirrorOpen{found.solutions[1].p_W};
  located.next_check = kOpenMirrorPeriod;
  state.settled = !located.youth;
  a->state = located;
  a->advice = found.advice;
  a->gate.reset();
  log(log_sink, LogLevel::info,
      "anchor " + std::to_string(a->id) + " found at " + text(best.p_W) + " m, " + elapsed.text(t) +
          (found.solutions.size() > 1 ? ", or its mirror image at " + text(found.solutions[1].p_W)
                                      : ""));
}

bool RangeLayer::Impl::tryToFind(TimeNs t, AnchorTrack* a, Collecting* collecting,
                                 const Held& held) {
  const std::vector<window::HeldRange> ranges = allHeld(*a, held);
  std::size_t n = 0;
  for (const window::HeldRange& r : ranges) n += static_cast<std::size_t>(r.merged);
  if (static_cast<int>(n) < options.min_ranges ||
      n < collecting->tried_with + collecting->tried_with / 20 + 3) {
    return false;
  }
  collecting->tried_with = n;
  const ranging::AnchorInitialization found = solveEitherWay(a, ranges);
  a->advice = found.advice;
  // What comes at rest is averaged: waiting brings nothing that the search does not have.
  if (!a->prior && static_cast<int>(ranges.size()) < options.min_ranges) {
    a->advice = "move further: " + std::to_string(n) + " ranges so far, but from " +
                std::to_string(ranges.size()) + " of the " + std::to_string(options.min_ranges) +
                " places that are needed";
  }
  collecting->candidates.clear();
  if (found.geometry != ranging::AnchorGeometry::inconsistent) {
    for (const ranging::AnchorSolution& s : found.solutions)
      collecting->candidates.push_back({s.p_W, s.covariance.topLeftCorner<3, 3>()});
  }
  if (!isUsable(found)) return false;
  adopt(t, a, found);
  return true;
}

void RangeLayer::Impl::endYouth(const AnchorTrack& a, Located* located) {
  located->youth.reset();
  window->anchor(a.key())->settled = true;
}

void RangeLayer::Impl::moveTo(TimeNs t, AnchorTrack* a, Located* located, const Vec3& p_W) {
  window::AnchorNode& state = *window->anchor(a->key());
  for (int i = 0; i < 3; ++i) state.x[i] = p_W[i];
  // Its mirror image is another one now: decideMirror() looks for it.
  located->mirror = MirrorUnseen{};
  located->next_check = 1;
  a->gate.reset();
  log(log_sink, LogLevel::info,
      "anchor " + std::to_string(a->id) + " is rather at " + text(p_W) + " m, " + elapsed.text(t));
}

/// The first ranges of an anchor leave a ring or a valley of positions, and what the window makes
/// of the point the search landed on may stay behind a ridge. So a young anchor is searched for
/// again and again, and goes where the long window, path and all, is better explained.
bool RangeLayer::Impl::searchAgain(TimeNs t, AnchorTrack* a, Located* located, const Held& held,
                                   const std::vector<window::HeldRange>& head) {
  if (!located->youth || --located->youth->next_search > 0) return false;
  located->youth->next_search = kSearchPeriod;
  window::AnchorNode& state = *window->anchor(a->key());
  const std::vector<window::HeldRange> ranges = held(a->key());
  const ranging::AnchorInitialization found = solve(*a, ranges, a->uncalibrated);
  const bool old = t - located->found_at > fromSeconds(kLongestYouthS);
  const bool usable = isUsable(found);
  if (usable) located->youth->search_covariance = found.solutions.front().covariance;
  bool moved = false;
  if (usable && !state.fixed) {
    const Vec3 there = found.solutions.front().p_W;
    const MirrorComparison m = compareMirror(*window, a->key(), ranges, head, &there);
    const bool better_there = m.distinct && m.chi2 < -kMirrorSwitch;
    const Vec3 target = better_there ? m.mirror_p_W : m.here_p_W;
    moved = m.valid && (target - state.position()).norm() > kStuck;
    if (moved) moveTo(t, a, located, target);
  }
  const bool known = usable && !moved && found.needed_sigma_m < kSettledSigma;
  if (old || known) endYouth(*a, located);
  located->well_known = located->well_known || known;
  return moved;
}

bool RangeLayer::Impl::decideMirror(TimeNs t, AnchorTrack* a, Located* located, const Held& held,
                                    const std::vector<window::HeldRange>& head) {
  const bool ruled_out = std::holds_alternative<MirrorRuledOut>(located->mirror);
  if (ruled_out || --located->next_check > 0) return false;
  const MirrorOpen* open = located->openMirror();
  located->next_check = open != nullptr ? kOpenMirrorPeriod : kMirrorPeriod;
  window::AnchorNode& state = *window->anchor(a->key());
  if (state.fixed) return false;
  const MirrorComparison m = compareMirror(*window, a->key(), held(a->key()), head,
                                           open != nullptr ? &open->p_W : nullptr);
  if (!m.valid) return false;
  if (!m.distinct || m.chi2 > kMirrorClosed) {
    if (m.distinct) {
      located->mirror = MirrorRuledOut{};
    } else {
      located->mirror = MirrorUnseen{};
    }
    a->advice.clear();
    return false;
  }
  located->mirror = MirrorOpen{m.mirror_p_W};
  a->advice = "change height: two positions " +
              std::to_string((m.mirror_p_W - state.position()).norm()).substr(0, 4) +
              " m apart fit, mirrored at the plane of motion";
  if (m.chi2 > -kMirrorSwitch) return false;
  located->mirror = MirrorOpen{state.position()};
  for (int i = 0; i < 3; ++i) state.x[i] = m.mirror_p_W[i];
  a->gate.reset();
  log(log_sink, LogLevel::info,
      "anchor " + std::to_string(a->id) + ": its mirror image at " + text(m.mirror_p_W) +
          " m fits better, " + elapsed.text(t));
  return true;
}

bool RangeLayer::Impl::trusted(const AnchorTrack& a, bool well_known) {
  return a.used > 50 && (well_known || static_cast<double>(a.used) >
                                           kTrusted * static_cast<double>(a.used + a.rejected));
}

bool RangeLayer::Impl::giveUpIfElsewhere(TimeNs t, AnchorTrack* a, const Located& located) {
  if (!a->gate.suspicious()) return false;
  giveUp(t, a, trusted(*a, located.well_known));
  return true;
}

void RangeLayer::Impl::giveUp(TimeNs t, AnchorTrack* a, bool trusted) {
  warn("anchor " + std::to_string(a->id) + " at " + elapsed.text(t) + ": its ranges contradict " +
       (trusted ? "its position, it has been moved" : "its first position, which was wrong") +
       "; being found anew");
  // What it measured before it was moved stays true of the anchor it was then.
  if (trusted) {
    a->former.reset();
    a->former = std::make_shared<AnchorTrack>(*a);
  } else {
    window->removeAnchor(a->key());
  }
  if (trusted) distances.forget(a->id);
  a->former_evidence = 0;
  a->generation = ++a->generations;
  a->state = Collecting{true, 0};
  a->advice = std::string("move sideways: it ") +
              (trusted ? "has been moved" : "is not where it seemed to be") +
              ", and is being found anew";
  a->prior.reset();
  a->uncalibrated = a->told_uncalibrated = false;
  a->left_survey = a->left_survey || (a->tied && trusted);
  a->tied = false;
  a->used = a->rejected = 0;
  a->gate.reset();
  ++found_anew;
}

void RangeLayer::Impl::compareWithFormer(AnchorTrack* a, const AntennaPrediction& antenna,
                                         const window::HeldRange& held) {
  if (!a->former) return;
  const window::AnchorNode* before = window->anchor(a->former->key());
  if (before == nullptr) {
    a->former.reset();
    return;
  }
  const window::AnchorNode* now = window->anchor(a->key());
  const Innovation there = innovation(*a->former, *before, antenna, held);
  double here = kAnywhere;
  if (now != nullptr) {
    const Innovation i = innovation(*a, *now, antenna, held);
    here = logLikelihood(i.residual, i.variance);
  }
  const double gain = logLikelihood(there.residual, there.variance) - here;
  a->former_evidence = std::max(0.0, a->former_evidence + gain / kRangesPerEvidence);
}

bool RangeLayer::Impl::returnIfFormerFits(TimeNs t, AnchorTrack* a) {
  if (!a->former || a->former_evidence < kFormerEvidence) return false;
  if (window->anchor(a->former->key()) == nullptr) return false;
  if (window->anchor(a->key()) != nullptr) window->removeAnchor(a->key());
  const std::shared_ptr<const AnchorTrack> former = a->former;
  const int generations = a->generations;
  *a = *former;
  a->generations = generations;
  a->gate.reset();
  ++taken_up_again;
  log(log_sink, LogLevel::info,
      "anchor " + std::to_string(a->id) + ": its ranges agree with its former position again, " +
          elapsed.text(t));
  return true;
}

void RangeLayer::Impl::reweigh(AnchorTrack* a, const Held& held) {
  window::AnchorNode& state = *window->anchor(a->key());
  std::vector<ranging::RangeResidual> residuals;
  for (const window::HeldRange& r : held(a->key())) {
    if (r.merged > 1) continue;
    const factors::RangePrediction e =
        factors::predictRange(r.motion, state.position(), state.x[3], r.range_m);
    residuals.push_back({r.t, -e.value_m, r.sigma_m});
  }
  const ranging::RangeCorrelation c =
      ranging::rangeCorrelation(ranging::withoutSlowPart(residuals, kSlowPartS));
  // A claimed sigma above the scatter already covers some of the correlation.
  const double now = c.correlation_factor * c.rms_ratio * c.rms_ratio;
  // Slowly: the residuals themselves depend on the weights.
  state.variance_factor = std::clamp(0.5 * (state.variance_factor + now), kLeastFactor, 30.0);
}

bool RangeLayer::update(TimeNs t, const Held& held, const std::vector<window::HeldRange>& head,
                        const HeldDifferences& differences) {
  Impl& s = *impl_;
  ++s.keyframes;
  bool changed = s.updateSurvey(t, held, differences);
  for (auto& [id, a] : s.tracks) {
    changed = s.returnIfFormerFits(t, &a) || changed;
    if (Collecting* collecting = a.collecting()) {
      changed = s.tryToFind(t, &a, collecting, held) || changed;
      continue;
    }
    Located* located = a.located();
    if (s.giveUpIfElsewhere(t, &a, *located)) {
      changed = true;
      continue;
    }
    // Where a surveyed anchor is, its survey decides, with all the others.
    if (!a.tied) changed = s.searchAgain(t, &a, located, held, head) || changed;
    changed = s.decideBias(t, &a, located, held) || changed;
    if (!a.tied) changed = s.decideMirror(t, &a, located, held, head) || changed;
    if (s.window->options().anchor_fixed_after_init && t - located->found_at > fromSeconds(1.0)) {
      s.window->anchor(a.key())->fixed = true;
    }
    if (s.options.correlation && s.keyframes % kCorrelationPeriod == 0) s.reweigh(&a, held);
  }
  if (changed || s.keyframes % kCorrelationPeriod == 0) s.setDistances();
  // Earlier generations go when no keyframe holds their ranges any more.
  std::vector<std::uint64_t> gone;
  for (const auto& [key, state] : s.window->anchors()) {
    const AnchorTrack& a = s.tracks.at(key & ((1ull << 48) - 1));
    if (key != a.key() && held(key).empty()) gone.push_back(key);
  }
  for (std::uint64_t key : gone) s.window->removeAnchor(key);
  return changed;
}

}  // namespace vir::estimator
