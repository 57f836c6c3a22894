#include "vir/estimator/range_layer.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

#include "range_layer_impl.h"

namespace vir::estimator {

namespace {

/// Nearer together [m] two antennas are one; and so many at most.
constexpr double kSameAntenna = 1e-3;
constexpr std::size_t kMostAntennas = 16;

}  // namespace

void describe(OptionVisitor& v, RangeOptions& o) {
  v.section("Ranges", "Ranges to anchors: noise, gate, how anchors are found");
  v.value("sigma_m", o.sigma_m, {1e-3, 100.0}, "noise of a range, if the recording does not say");
  v.value("sigma_scale", o.sigma_scale, {0.01, 100.0}, "factor on the noise the recording gives");
  v.value("bias_sigma_m", o.bias_sigma_m, {1e-4, 10.0},
          "how large the constant bias of an anchor's ranges may be if the board is calibrated");
  v.value("uncalibrated_bias_sigma_m", o.uncalibrated_bias_sigma_m, {0.0, 10.0},
          "the same if it is not (half of the boards are not; the ranges tell); 0: all are");
  v.value("max_range_m", o.max_range_m, {0.1, 1e5}, "longer ranges are absurd");
  v.value("correlation", o.correlation,
          "estimate how much successive ranges err together, and weigh them accordingly");
  v.value("gate_sigma", o.gate_sigma, {1.0, 100.0}, "ranges further off are not used [sigma]");
  v.value("min_ranges", o.min_ranges, {4, 10000}, "ranges needed before an anchor is looked for");
  v.value("max_anchor_sigma_m", o.max_anchor_sigma_m, {0.01, 1000.0},
          "an anchor whose position is less certain (horizontally) is not used yet");
  v.value("floor_sigma_m", o.floor_sigma_m, {0.0, 1000.0},
          "how far above or below a robot that stays level an anchor is: its ranges hardly tell; "
          "0: no idea");
  v.value("drift_ratio", o.drift_ratio, {0.0, 1.0},
          "error of the path relative to its length, for finding anchors");
  v.value("path_scale_sigma", o.path_scale_sigma, {0.0, 1.0},
          "relative error of the path's length when an anchor is looked for");
  v.value("restart_s", o.restart_s, {0.1, 1e4},
          "ranges rejected for so long: the anchor was moved, or its start was wrong");
  v.value("bias_model", o.bias_model_file,
          "file of `vir-slam calibrate uwb`: bias over distance; empty = none");
  v.value("surveyed_anchors", o.surveyed_anchors,
          "table id,x,y,z,sigma of anchors measured in a frame of their own [m]; empty = none");
  v.value("anchor_names", o.anchor_names,
          "numbers of anchors that the table calls by name: name=number, repeated");
  v.value("anchor_prior", o.anchor_prior, 0,
          "known about anchors in the start's frame: id x y z sigma, repeated [m]");
}

ranging::GateOptions RangeLayer::Impl::gateOptions() const {
  ranging::GateOptions gate;
  gate.chi2 = options.gate_sigma * options.gate_sigma;
  gate.max_reject_s = options.restart_s;
  return gate;
}

AnchorTrack& RangeLayer::Impl::track(std::uint64_t id) {
  const auto it = tracks.find(id);
  if (it != tracks.end()) return it->second;
  AnchorTrack& a = tracks[id];
  a.id = id;
  a.gate = ranging::RangeGate(gateOptions());
  return a;
}

void RangeLayer::Impl::setPrior(std::uint64_t id, const Vec3& p_W, double sigma_m) {
  ranging::AnchorPrior prior;
  prior.p_W = p_W;
  prior.covariance = Mat3::Identity() * sigma_m * sigma_m;
  track(id).prior = prior;
}

void RangeLayer::Impl::travelTo(const Vec3& antenna_W) {
  if (any_antenna) travelled_m += (antenna_W - last_antenna).norm();
  any_antenna = true;
  last_antenna = antenna_W;
  lowest_antenna_m = std::min(lowest_antenna_m, antenna_W.z());
}

RangeRecord RangeLayer::Impl::recordOf(const Range& r) {
  RangeRecord d;
  d.t = r.t;
  d.anchor = r.anchor;
  d.reference = r.reference;
  d.measured_m = r.range_m;
  return d;
}

RangeRecord RangeLayer::Impl::recordOf(const Range& r, double residual_m, double variance) {
  RangeRecord d = recordOf(r);
  d.predicted_m = r.range_m - residual_m;
  d.residual_m = residual_m;
  d.sigma_m = std::sqrt(variance);
  return d;
}

void RangeLayer::Impl::record(const Range& r, RangeDecision decision) {
  RangeRecord d = recordOf(r);
  d.decision = decision;
  decisions.push_back(d);
}

/// Two antennas of a robot measure to one anchor at one time: neither repeats the other.
RangeLayer::Impl::Antenna& RangeLayer::Impl::antennaAt(const Vec3& p_B_U) {
  for (Antenna& a : antennas) {
    if ((a.p_B_U - p_B_U).norm() < kSameAntenna) return a;
  }
  if (antennas.size() < kMostAntennas) {
    antennas.push_back({p_B_U, ranging::RangeCheck(checkOptions(options)), {}});
  }
  return antennas.back();
}

void RangeLayer::begin(TimeNs t) { impl_->elapsed.begin(t); }

void RangeLayer::offer(const AnchorRange& range) {
  Impl& s = *impl_;
  if (!s.distances.add(range, s.options.sigma_m, s.options.max_range_m)) ++s.anchor_ranges_unusable;
}

void RangeLayer::offer(const Range& range) {
  Impl& s = *impl_;
  // A negative id of the radio arrives as a huge one; both would alias another anchor.
  constexpr std::uint64_t kLargestId = std::numeric_limits<int>::max();
  if (range.anchor > kLargestId || range.reference.value_or(0) > kLargestId) {
    s.record(range, RangeDecision::bad_id);
    return;
  }
  if (!range.p_B_U.allFinite() || !std::isfinite(range.sigma_m)) {
    s.record(range, RangeDecision::not_finite);
    return;
  }
  const RangeDecision problem =
      range.reference ? s.checkDifference(range)
                      : s.antennaAt(range.p_B_U)
                            .check.check(static_cast<int>(range.anchor), range.t, range.range_m);
  if (problem != RangeDecision::accepted) {
    s.record(range, problem);
    return;
  }
  const auto later = [](TimeNs t, const Range& r) { return t < r.t; };
  s.pending.insert(std::upper_bound(s.pending.begin(), s.pending.end(), range.t, later), range);
}

std::vector<Range> RangeLayer::dueUntil(TimeNs t) {
  std::vector<Range>& p = impl_->pending;
  const auto end = std::find_if(p.begin(), p.end(), [&](const Range& r) { return r.t > t; });
  std::vector<Range> out(p.begin(), end);
  p.erase(p.begin(), end);
  return out;
}

void RangeLayer::discard(const std::vector<Range>& ranges, RangeDecision why) {
  for (const Range& r : ranges) impl_->record(r, why);
}

RangeLayer::Impl::Innovation RangeLayer::Impl::innovation(const AnchorTrack& a,
                                                          const window::AnchorNode& state,
                                                          const AntennaPrediction& antenna,
                                                          const window::HeldRange& held) const {
  const factors::RangePrediction r =
      factors::predictRange(antenna.p_W, state.position(), state.x[3], held.range_m);
  double variance =
      held.sigma_m * held.sigma_m + r.direction.dot(antenna.inner_covariance * r.direction);
  const int c = window->columnOf(a.key());
  if (c >= 0) {
    const Vec3 arm = antenna.p_W - window->head().position();
    Eigen::Matrix<double, 9, 1> h;
    h << r.direction, r.direction.dot(Vec3(-arm.y(), arm.x(), 0)), 0, -r.direction, 1;
    const Eigen::MatrixXd& J = window->jointCovariance();
    Eigen::Matrix<double, 9, 9> P;
    P << J.topLeftCorner<5, 5>(), J.block<5, 4>(0, c), J.block<4, 5>(c, 0), J.block<4, 4>(c, c);
    variance += std::max(0.0, h.dot(P * h));
  }
  if (a.located() != nullptr && a.located()->youth) {
    Eigen::Vector4d h;
    h << -r.direction, 1;
    variance += h.dot(a.located()->youth->search_covariance * h);
  }
  return {-r.value_m, variance};
}

bool RangeLayer::accept(const Range& range, const AntennaPrediction& antenna,
                        window::HeldRange* held) {
  Impl& s = *impl_;
  if (range.reference) return s.acceptDifference(range, antenna, held);
  AnchorTrack& a = s.track(range.anchor);
  s.travelTo(antenna.p_W);
  held->t = range.t;
  held->anchor = a.key();
  held->range_m = s.options.bias_model.corrected(range.range_m);
  held->sigma_m = s.sigmaOf(range);
  held->merged = 1;
  s.compareWithFormer(&a, antenna, *held);
  const window::AnchorNode* state = s.window->anchor(a.key());
  if (!state) {
    s.record(range, RangeDecision::collected);
    ++a.collected;
    return true;
  }
  const auto [residual, variance] = s.innovation(a, *state, antenna, *held);
  const RangeDecision decision = a.gate.check(range.t, residual, variance, s.travelled_m);
  RangeRecord d = Impl::recordOf(range, residual, variance);
  const factors::RangeTerm term = s.window->termOf(a.key(), held->range_m, held->sigma_m);
  bool accepted = decision == RangeDecision::accepted;
  Located* located = a.located();
  const MirrorOpen* mirror = located != nullptr ? located->openMirror() : nullptr;
  if (!accepted && mirror != nullptr) {
    // Evidence for the other position must not be thrown away: it decides.
    const factors::RangePrediction there =
        factors::predictRange(antenna.p_W, mirror->p_W, state->x[3], held->range_m);
    accepted = std::abs(there.value_m) < s.options.gate_sigma * std::sqrt(variance);
    located->next_check = 1;
  }
  d.weight = accepted ? term.robust.evaluate(residual / term.sigma_m).weight : 0;
  d.decision = accepted ? RangeDecision::accepted : decision;
  s.decisions.push_back(d);
  ++(accepted ? a.used : a.rejected);
  if (accepted || !s.isSurveyed(range.anchor) || decision == RangeDecision::invalid)
    return accepted;
  held->anchor = a.doubtedKey();
  return true;
}

void RangeLayer::putDown(std::uint64_t id, const Vec3& p_W, double sigma_m) {
  const bool possible = id <= static_cast<std::uint64_t>(std::numeric_limits<int>::max()) &&
                        p_W.allFinite() && sigma_m > 0 && std::isfinite(sigma_m);
  if (!possible) {
    ++impl_->put_down_unusable;
    impl_->warn("anchor " + std::to_string(id) + " was put down with sigma " +
                std::to_string(sigma_m) + " m at a place or under an id that cannot be: not used");
    return;
  }
  AnchorTrack& a = impl_->track(id);
  if (a.located() != nullptr) return;
  impl_->setPrior(id, p_W, std::max(sigma_m, kLeastPriorSigma));
}

void RangeLayer::putDownUnseen(std::uint64_t id) {
  ++impl_->put_down_unseen;
  impl_->warn("anchor " + std::to_string(id) +
              " was put down when there was no pose to place it from: that is not used, it will be "
              "found from its ranges");
}

std::vector<Anchor> RangeLayer::anchors() const {
  std::vector<Anchor> out;
  for (const auto& [id, a] : impl_->tracks) {
    Anchor r;
    r.id = id;
    r.ranges_used = a.used;
    r.ranges_rejected = a.rejected;
    r.advice = a.advice;
    const bool moved = a.collecting() != nullptr && a.collecting()->moved;
    r.state = moved ? AnchorState::moved : AnchorState::collecting;
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
      const MirrorOpen* mirror = a.located() != nullptr ? a.located()->openMirror() : nullptr;
      r.state = it->second.fixed    ? AnchorState::fixed
                : mirror != nullptr ? AnchorState::mirror_open
                                    : AnchorState::estimated;
      if (mirror != nullptr) {
        // Spread over both positions: each alone would promise a height that nobody knows. Whoever
        // uses this covariance must not widen it by the other position again.
        r.mirror_p_W = mirror->p_W;
        const Vec3 half = 0.5 * (r.mirror_p_W - r.p_W);
        r.covariance += half * half.transpose();
      }
    }
    impl_->advise(a, &r);
    out.push_back(std::move(r));
  }
  return out;
}

std::vector<RangeRecord> RangeLayer::take() { return std::exchange(impl_->decisions, {}); }
std::vector<std::string> RangeLayer::takeWarnings() { return std::exchange(impl_->warnings, {}); }

std::vector<std::pair<std::string, long>> RangeLayer::counters() const {
  std::vector<std::pair<std::string, long>> out;
  if (impl_->found_anew > 0) out.emplace_back("anchors_found_anew", impl_->found_anew);
  if (impl_->taken_up_again > 0) {
    out.emplace_back("anchors_taken_up_again", impl_->taken_up_again);
  }
  if (impl_->put_down_unseen > 0) {
    out.emplace_back("anchors_put_down_without_a_pose", impl_->put_down_unseen);
  }
  if (impl_->put_down_unusable > 0) {
    out.emplace_back("anchors_put_down_unusable", impl_->put_down_unusable);
  }
  long differences = 0, without_place = 0;
  for (const auto& [pair, d] : impl_->differences) {
    differences += d.heard();
    without_place += d.collected;
  }
  if (differences > 0) {
    out.emplace_back("range_differences", differences);
    out.emplace_back("range_differences_without_a_place", without_place);
  }
  if (impl_->anchor_ranges_unusable > 0) {
    out.emplace_back("anchor_ranges_unusable", impl_->anchor_ranges_unusable);
  }
  return out;
}

RangeLayer::RangeLayer(const RangeOptions& options, window::LongWindow* window, LogSink log)
    : impl_(std::make_unique<Impl>(options, window, std::move(log))) {}
RangeLayer::~RangeLayer() = default;

}  // namespace vir::estimator
