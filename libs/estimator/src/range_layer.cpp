#include "vir/estimator/range_layer.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "anchor_track.h"
#include "mirror.h"
#include "vir/ranging/range_check.h"
#include "vir/ranging/range_correlation.h"

namespace vir {
namespace {

/// Keyframes between two looks at an open mirror image, and between two estimates of correlation.
constexpr int kMirrorPeriod = 15, kOpenMirrorPeriod = 3;
constexpr int kCorrelationPeriod = 10;
/// Twice the difference in loss between the mirror image and the present position that closes the
/// question, and that decides against the present one.
constexpr double kMirrorClosed = 30, kMirrorSwitch = 2;
/// Share of ranges an anchor must have explained before a contradiction means that it was moved;
/// below, its start was wrong.
constexpr double kTrusted = 0.7;
/// Span of the mean taken off residuals before their correlation is estimated [s], and how many
/// ranges it needs.
constexpr double kSlowPartS = 6.0;
constexpr double kFewestForMean = 10;
/// A claimed sigma may turn out too large; its square is not cut below this share.
constexpr double kLeastFactor = 0.2;

/// Residuals less their mean over a few seconds around: what changes more slowly is the
/// trajectory's error (or a bias), and taking it for the ranges' own would make them count for less
/// and less.
std::vector<RangeResidual> withoutSlowPart(std::vector<RangeResidual> residuals) {
  std::stable_sort(residuals.begin(), residuals.end(),
                   [](const RangeResidual& a, const RangeResidual& b) { return a.t < b.t; });
  const TimeNs half = fromSeconds(kSlowPartS / 2);
  std::vector<RangeResidual> out;
  out.reserve(residuals.size());
  std::size_t first = 0, last = 0;  // [first, last) lies within `half` of the present one
  double sum = 0;
  for (const RangeResidual& r : residuals) {
    while (last < residuals.size() && residuals[last].t <= r.t + half) {
      sum += residuals[last++].residual_m;
    }
    while (residuals[first].t < r.t - half) sum -= residuals[first++].residual_m;
    const double n = static_cast<double>(last - first);
    if (n < kFewestForMean) continue;
    RangeResidual high = r;
    high.residual_m = (r.residual_m - sum / n) * std::sqrt(n / (n - 1));
    out.push_back(high);
  }
  return out;
}

std::string seconds(TimeNs t) { return std::to_string(toSeconds(t)) + " s"; }

std::string text(const Vec3& p) {
  char out[80];
  std::snprintf(out, sizeof out, "(%.2f, %.2f, %.2f)", p.x(), p.y(), p.z());
  return out;
}

}  // namespace

void describe(OptionVisitor& v, RangeOptions& o) {
  v.section("Ranges", "Ranges to anchors: noise, gate, how anchors are found");
  v.value("sigma_m", o.sigma_m, {1e-3, 100.0}, "noise of a range, if the recording does not say");
  v.value("sigma_scale", o.sigma_scale, {0.01, 100.0}, "factor on the noise the recording gives");
  v.value("bias_sigma_m", o.bias_sigma_m, {1e-4, 10.0},
          "how large the constant bias of an anchor's ranges may be");
  v.value("max_range_m", o.max_range_m, {0.1, 1e5}, "longer ranges are absurd");
  v.value("correlation", o.correlation,
          "estimate how much successive ranges err together, and weigh them accordingly");
  v.value("gate_sigma", o.gate_sigma, {1.0, 100.0}, "ranges further off are not used [sigma]");
  v.value("min_ranges", o.min_ranges, {4, 10000}, "ranges needed before an anchor is looked for");
  v.value("max_anchor_sigma_m", o.max_anchor_sigma_m, {0.01, 1000.0},
          "an anchor whose position is less certain (horizontally) is not used yet");
  v.value("drift_ratio", o.drift_ratio, {0.0, 1.0},
          "error of the path relative to its length, for finding anchors");
  v.value("restart_s", o.restart_s, {0.1, 1e4},
          "ranges rejected for so long: the anchor was moved, or its start was wrong");
  v.value("bias_model", o.bias_model_file,
          "file of `vir-slam calibrate uwb`: bias over distance; empty = none");
  v.value("anchor_prior", o.anchor_prior, 0,
          "known about anchors in the start's frame: id x y z sigma, repeated [m]");
}

struct RangeLayer::Impl {
  Impl(const RangeOptions& o, LongWindow* w, LogSink l)
      : options(o), window(w), log_sink(std::move(l)), check(checkOptions(o)) {
    for (std::size_t i = 0; i + 4 < o.anchor_prior.size(); i += 5) {
      const double* v = &o.anchor_prior[i];
      setPrior(static_cast<std::uint64_t>(v[0]), Vec3(v[1], v[2], v[3]), v[4]);
    }
  }
  static RangeCheckOptions checkOptions(const RangeOptions& o) {
    RangeCheckOptions c;
    c.max_range_m = o.max_range_m;
    return c;
  }

  AnchorTrack& track(std::uint64_t id);
  void setPrior(std::uint64_t id, const Vec3& p_W, double sigma_m);
  void record(const RangeMeasurement& r, const std::string& decision);
  double sigmaOf(const RangeMeasurement& r) const {
    return r.sigma_m > 0 ? r.sigma_m * options.sigma_scale : options.sigma_m;
  }
  AnchorInitialization solve(const AnchorTrack& a, const std::vector<HeldRange>& held) const;
  bool tryToFind(TimeNs t, AnchorTrack* a, const Held& held);
  void adopt(TimeNs t, AnchorTrack* a, const AnchorInitialization& found);
  bool settleMirror(TimeNs t, AnchorTrack* a, const Held& held,
                    const std::vector<HeldRange>& front);
  bool giveUpIfElsewhere(TimeNs t, AnchorTrack* a);
  void reweigh(AnchorTrack* a, const Held& held);
  void warn(const std::string& text) {
    log(log_sink, LogLevel::warning, text);
    warnings.push_back(text);
  }

  RangeOptions options;
  LongWindow* window;
  LogSink log_sink;
  RangeCheck check;
  std::map<std::uint64_t, AnchorTrack> tracks;
  std::vector<RangeMeasurement> pending;  ///< ordered by time
  std::vector<RangeDecision> decisions;
  std::vector<std::string> warnings;
  std::map<std::string, long> counts;
  double travelled_m = 0;
  Vec3 last_antenna = Vec3::Zero();
  bool any_antenna = false;
  int keyframes = 0;
};

AnchorTrack& RangeLayer::Impl::track(std::uint64_t id) {
  const auto it = tracks.find(id);
  if (it != tracks.end()) return it->second;
  AnchorTrack& a = tracks[id];
  a.id = id;
  GateOptions gate;
  gate.chi2 = options.gate_sigma * options.gate_sigma;
  gate.max_reject_s = options.restart_s;
  a.gate = RangeGate(gate);
  return a;
}

void RangeLayer::Impl::setPrior(std::uint64_t id, const Vec3& p_W, double sigma_m) {
  AnchorPrior prior;
  prior.p_W = p_W;
  prior.covariance = Mat3::Identity() * sigma_m * sigma_m;
  track(id).prior = prior;
}

void RangeLayer::Impl::record(const RangeMeasurement& r, const std::string& decision) {
  RangeDecision d;
  d.t = r.t;
  d.anchor = r.anchor;
  d.measured_m = r.range_m;
  d.decision = decision;
  decisions.push_back(d);
  ++counts[decision];
}

void RangeLayer::offer(const RangeMeasurement& range) {
  Impl& s = *impl_;
  // A negative id of the radio arrives as a huge one; both would alias another anchor.
  if (range.anchor > static_cast<std::uint64_t>(std::numeric_limits<int>::max())) {
    s.record(range, "bad_id");
    return;
  }
  const RangeProblem problem =
      s.check.check(static_cast<int>(range.anchor), range.t, range.range_m);
  if (problem != RangeProblem::none) {
    s.record(range, name(problem));
    return;
  }
  if (!range.p_B_U.allFinite() || !std::isfinite(range.sigma_m)) {
    s.record(range, "not_finite");
    return;
  }
  const auto later = [](TimeNs t, const RangeMeasurement& r) { return t < r.t; };
  s.pending.insert(std::upper_bound(s.pending.begin(), s.pending.end(), range.t, later), range);
}

std::vector<RangeMeasurement> RangeLayer::dueUntil(TimeNs t) {
  std::vector<RangeMeasurement>& p = impl_->pending;
  const auto end =
      std::find_if(p.begin(), p.end(), [&](const RangeMeasurement& r) { return r.t > t; });
  std::vector<RangeMeasurement> out(p.begin(), end);
  p.erase(p.begin(), end);
  return out;
}

void RangeLayer::discard(const std::vector<RangeMeasurement>& ranges, const std::string& why) {
  for (const RangeMeasurement& r : ranges) impl_->record(r, why);
}

bool RangeLayer::judge(const RangeMeasurement& range, const AntennaPrediction& antenna,
                       HeldRange* held) {
  Impl& s = *impl_;
  AnchorTrack& a = s.track(range.anchor);
  if (s.any_antenna) s.travelled_m += (antenna.p_W - s.last_antenna).norm();
  s.any_antenna = true;
  s.last_antenna = antenna.p_W;
  held->t = range.t;
  held->anchor = a.key();
  held->range_m = s.options.bias_model.corrected(range.range_m);
  held->sigma_m = s.sigmaOf(range);
  held->merged = 1;
  const AnchorState* state = s.window->anchor(a.key());
  if (!state) {
    s.record(range, "collected");
    ++a.collected;
    return true;
  }
  const RangePrediction r =
      predictRange(antenna.p_W, state->position(), state->x[3], held->range_m);
  double variance =
      held->sigma_m * held->sigma_m + r.direction.dot(antenna.inner_covariance * r.direction);
  const int c = s.window->columnOf(a.key());
  if (c >= 0) {
    const Vec3 arm = antenna.p_W - s.window->front().position();
    Eigen::Matrix<double, 9, 1> h;
    h << r.direction, r.direction.dot(Vec3(-arm.y(), arm.x(), 0)), 0, -r.direction, 1;
    const Eigen::MatrixXd& J = s.window->jointCovariance();
    Eigen::Matrix<double, 9, 9> P;
    P << J.topLeftCorner<5, 5>(), J.block<5, 4>(0, c), J.block<4, 5>(c, 0), J.block<4, 4>(c, c);
    variance += std::max(0.0, h.dot(P * h));
  }
  const double residual = -r.value_m;  // measured - predicted
  const GateDecision decision = a.gate.check(range.t, residual, variance, s.travelled_m);
  RangeDecision d;
  d.t = range.t;
  d.anchor = range.anchor;
  d.measured_m = range.range_m;
  d.predicted_m = range.range_m - residual;
  d.residual_m = residual;
  d.sigma_m = std::sqrt(variance);
  const RangeTerm term = s.window->termOf(a.key(), held->range_m, held->sigma_m);
  bool accepted = decision == GateDecision::accepted;
  if (!accepted && a.phase == AnchorPhase::mirror_open) {
    // Evidence for the other position must not be thrown away: it decides.
    const RangePrediction there =
        predictRange(antenna.p_W, a.mirror_p_W, state->x[3], held->range_m);
    accepted = std::abs(there.value_m) < s.options.gate_sigma * std::sqrt(variance);
    a.next_check = 1;
  }
  d.weight = accepted ? term.robust.evaluate(residual / term.sigma_m).weight : 0;
  d.decision = accepted ? name(GateDecision::accepted) : name(decision);
  s.decisions.push_back(d);
  ++s.counts[d.decision];
  ++(accepted ? a.used : a.rejected);
  return accepted;
}

AnchorInitialization RangeLayer::Impl::solve(const AnchorTrack& a,
                                             const std::vector<HeldRange>& held) const {
  std::vector<AntennaRange> samples;
  samples.reserve(held.size());
  for (const HeldRange& r : held) samples.push_back({r.motion, r.range_m, r.sigma_m});
  AnchorInitOptions o;
  o.min_ranges = options.min_ranges;
  o.bias_sigma_m = options.bias_sigma_m;
  o.max_sigma_m = options.max_anchor_sigma_m;
  o.drift_ratio = options.drift_ratio;
  o.correlation = options.correlation;
  return initializeAnchor(samples, o, a.prior);
}

void RangeLayer::Impl::adopt(TimeNs t, AnchorTrack* a, const AnchorInitialization& found) {
  const AnchorSolution& best = found.solutions.front();
  // The ranges themselves stay factors of the window: the start's covariance must not count too.
  const double far = 20 + best.p_W.norm();
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Identity() * far * far;
  covariance(3, 3) = options.bias_sigma_m * options.bias_sigma_m;
  Eigen::Vector4d mean;
  mean << best.p_W, 0;
  if (a->prior) {
    covariance.topLeftCorner<3, 3>() = a->prior->covariance;
    mean.head<3>() = a->prior->p_W;
  }
  AnchorState& state = window->addAnchor(a->key(), mean, covariance);
  for (int i = 0; i < 3; ++i) state.x[i] = best.p_W[i];
  state.x[3] = best.bias_m;
  a->phase = found.solutions.size() > 1 ? AnchorPhase::mirror_open : AnchorPhase::estimated;
  if (found.solutions.size() > 1) a->mirror_p_W = found.solutions[1].p_W;
  a->advice = found.advice;
  a->found_at = t;
  a->moved = false;
  a->mirror_closed = false;
  a->gate.reset();
  a->next_check = kOpenMirrorPeriod;
  log(log_sink, LogLevel::info,
      "anchor " + std::to_string(a->id) + " found at " + text(best.p_W) + " m, " + seconds(t) +
          (found.solutions.size() > 1 ? ", or its mirror image at " + text(a->mirror_p_W) : ""));
}

bool RangeLayer::Impl::tryToFind(TimeNs t, AnchorTrack* a, const Held& held) {
  const std::vector<HeldRange> ranges = held(a->key());
  std::size_t n = 0;
  for (const HeldRange& r : ranges) n += static_cast<std::size_t>(r.merged);
  if (static_cast<int>(n) < options.min_ranges || n < a->tried_with + a->tried_with / 20 + 3) {
    return false;
  }
  a->tried_with = n;
  const AnchorInitialization found = solve(*a, ranges);
  a->advice = found.advice;
  const bool usable =
      found.geometry == AnchorGeometry::good || found.geometry == AnchorGeometry::mirror;
  if (!usable || found.solutions.empty()) return false;
  adopt(t, a, found);
  return true;
}

bool RangeLayer::Impl::settleMirror(TimeNs t, AnchorTrack* a, const Held& held,
                                    const std::vector<HeldRange>& front) {
  if (a->mirror_closed || --a->next_check > 0) return false;
  a->next_check = a->phase == AnchorPhase::mirror_open ? kOpenMirrorPeriod : kMirrorPeriod;
  AnchorState& state = *window->anchor(a->key());
  if (state.fixed) return false;
  const MirrorComparison m =
      compareMirror(*window, a->key(), held(a->key()), front,
                    a->phase == AnchorPhase::mirror_open ? &a->mirror_p_W : nullptr);
  if (!m.valid) return false;
  a->mirror_p_W = m.mirror_p_W;
  if (!m.distinct || m.chi2 > kMirrorClosed) {
    a->mirror_closed = m.distinct;
    a->phase = AnchorPhase::estimated;
    a->advice.clear();
    return false;
  }
  a->phase = AnchorPhase::mirror_open;
  a->advice = "change height: two positions " +
              std::to_string((m.mirror_p_W - state.position()).norm()).substr(0, 4) +
              " m apart fit, mirrored at the plane of motion";
  if (m.chi2 > -kMirrorSwitch) return false;
  a->mirror_p_W = state.position();
  for (int i = 0; i < 3; ++i) state.x[i] = m.mirror_p_W[i];
  a->gate.reset();
  log(log_sink, LogLevel::info,
      "anchor " + std::to_string(a->id) + ": its mirror image at " + text(m.mirror_p_W) +
          " m fits better, " + seconds(t));
  return true;
}

bool RangeLayer::Impl::giveUpIfElsewhere(TimeNs t, AnchorTrack* a) {
  if (!a->gate.suspicious()) return false;
  const bool trusted =
      a->used > kTrusted * static_cast<double>(a->used + a->rejected) && a->used > 50;
  warn("anchor " + std::to_string(a->id) + " at " + seconds(t) + ": its ranges contradict " +
       (trusted ? "its position, it has been moved" : "its first position, which was wrong") +
       "; being found anew");
  // What it measured before it was moved stays true of the anchor it was then.
  if (!trusted) window->removeAnchor(a->key());
  ++a->generation;
  a->phase = AnchorPhase::collecting;
  a->moved = true;
  a->tried_with = 0;
  a->prior.reset();
  a->used = a->rejected = 0;
  a->gate.reset();
  ++counts["anchors_found_anew"];
  return true;
}

void RangeLayer::Impl::reweigh(AnchorTrack* a, const Held& held) {
  AnchorState& state = *window->anchor(a->key());
  std::vector<RangeResidual> residuals;
  for (const HeldRange& r : held(a->key())) {
    if (r.merged > 1) continue;
    const RangePrediction e = predictRange(r.motion, state.position(), state.x[3], r.range_m);
    residuals.push_back({r.t, -e.value_m, r.sigma_m});
  }
  const RangeCorrelation c = rangeCorrelation(withoutSlowPart(residuals));
  // A claimed sigma above the scatter already covers some of the correlation.
  const double now = c.correlation_factor * c.rms_ratio * c.rms_ratio;
  // Slowly: the residuals themselves depend on the weights.
  state.variance_factor = std::clamp(0.5 * (state.variance_factor + now), kLeastFactor, 30.0);
}

bool RangeLayer::update(TimeNs t, const Held& held, const std::vector<HeldRange>& front) {
  Impl& s = *impl_;
  ++s.keyframes;
  bool changed = false;
  for (auto& [id, a] : s.tracks) {
    if (a.phase == AnchorPhase::collecting) {
      changed = s.tryToFind(t, &a, held) || changed;
      continue;
    }
    if (s.giveUpIfElsewhere(t, &a)) {
      changed = true;
      continue;
    }
    changed = s.settleMirror(t, &a, held, front) || changed;
    if (s.window->options().anchor_fixed_after_init && t - a.found_at > fromSeconds(1.0)) {
      s.window->anchor(a.key())->fixed = true;
    }
    if (s.options.correlation && s.keyframes % kCorrelationPeriod == 0) s.reweigh(&a, held);
  }
  // Earlier generations go when no keyframe holds their ranges any more.
  std::vector<std::uint64_t> gone;
  for (const auto& [key, state] : s.window->anchors()) {
    const AnchorTrack& a = s.tracks.at(key & ((1ull << 48) - 1));
    if (key != a.key() && held(key).empty()) gone.push_back(key);
  }
  for (std::uint64_t key : gone) s.window->removeAnchor(key);
  return changed;
}

void RangeLayer::dropped(std::uint64_t id, const Vec3& p_W, double sigma_m) {
  AnchorTrack& a = impl_->track(id);
  if (a.known()) return;
  impl_->setPrior(id, p_W, sigma_m);
}

std::vector<AnchorReport> RangeLayer::anchors() const {
  std::vector<AnchorReport> out;
  for (const auto& [id, a] : impl_->tracks) {
    AnchorReport r;
    r.id = id;
    r.used = a.used;
    r.rejected = a.rejected;
    r.advice = a.advice;
    r.state = a.moved ? "moved" : "collecting";
    const auto& known = impl_->window->anchors();
    const auto it = known.find(a.key());
    if (it != known.end()) {
      r.has_position = true;
      r.p_W = it->second.position();
      r.bias_m = it->second.x[3];
      const int c = impl_->window->columnOf(a.key());
      if (c >= 0) {
        const Eigen::MatrixXd& J = impl_->window->jointCovariance();
        r.covariance = J.block<3, 3>(c, c);
        r.bias_sigma_m = std::sqrt(std::max(0.0, J(c + 3, c + 3)));
      }
      r.state = it->second.fixed                      ? "fixed"
                : a.phase == AnchorPhase::mirror_open ? "mirror_open"
                                                      : "estimated";
      if (a.phase == AnchorPhase::mirror_open) {
        // Spread over both positions: each alone would promise a height that nobody knows.
        r.mirror_p_W = a.mirror_p_W;
        const Vec3 half = 0.5 * (r.mirror_p_W - r.p_W);
        r.covariance += half * half.transpose();
      }
    }
    out.push_back(std::move(r));
  }
  return out;
}

std::vector<RangeDecision> RangeLayer::take() { return std::exchange(impl_->decisions, {}); }
std::vector<std::string> RangeLayer::takeWarnings() { return std::exchange(impl_->warnings, {}); }
bool RangeLayer::anyPending() const { return !impl_->pending.empty(); }

std::vector<std::pair<std::string, long>> RangeLayer::counters() const {
  std::vector<std::pair<std::string, long>> out;
  for (const auto& [what, n] : impl_->counts) out.emplace_back("ranges_" + what, n);
  return out;
}

RangeLayer::RangeLayer(const RangeOptions& options, LongWindow* window, LogSink log)
    : impl_(std::make_unique<Impl>(options, window, std::move(log))) {}
RangeLayer::~RangeLayer() = default;

}  // namespace vir
