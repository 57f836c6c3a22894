#include "survey_faults.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>

namespace vir::ranging {
namespace {

/// Twice the log of the likelihood ratio that a fault takes to be believed, and that sets it apart
/// from the next likely one.
constexpr double kBelieved = 40, kApart = 20;
/// What each fault costs: an anchor elsewhere explains its ranges with a place of its own.
constexpr double kElsewhereCost = 20, kExchangedCost = 10, kUnitCost = 10;
/// Biases that differ more than boards do [m] are no biases.
constexpr double kBiasSpread = 0.45;
/// Calibrated boards until the ranges say so much (as above) against it.
constexpr double kUncalibrated = 16;
/// Beyond, all pairs are too many to try.
constexpr int kMostForPairs = 10;
constexpr int kMostFaults = 3;
/// With fewer anchors left in it a survey fits whatever it says.
constexpr std::size_t kFewestAnchors = 3;
/// What an anchor off its place has to show: fewer ranges say nothing; off by at least this [m] and
/// so many sigmas.
constexpr int kFewestRanges = 20, kFewestToTell = 8;
constexpr double kElsewhere = 0.3, kElsewhereSigmas = 5;
/// Of its ranges, too short for its place.
constexpr double kTooShortShare = 0.25;
/// What numbers may be that are no metres: mm, cm, feet, inches [m].
constexpr double kUnits[] = {0.001, 0.01, 0.3048, 0.0254};

struct Candidate {
  SurveyFinding finding;
  SurveyHypothesis hypothesis;
};

/// With the biases that boards may have.
void evaluateFree(const SurveyMatchOptions& options, SurveyHypothesis* h) {
  SurveyMatchOptions with = options;
  with.bias_sigma_m = std::max(options.bias_sigma_m, options.uncalibrated_bias_sigma_m);
  h->bias_sigma_m = with.bias_sigma_m;
  h->uncalibrated = with.bias_sigma_m > options.bias_sigma_m;
  h->places = placesOf(h->data, h->survey, with);
}

/// With calibrated boards, unless the ranges speak against that.
void evaluate(const SurveyMatchOptions& options, SurveyHypothesis* h) {
  SurveyHypothesis calibrated = *h;
  SurveyMatchOptions with = options;
  with.uncalibrated_bias_sigma_m = 0;
  evaluateFree(with, &calibrated);
  evaluateFree(options, h);
  const double gain =
      2 * (calibrated.places.raw_cost - h->places.raw_cost) / std::max(h->places.worth, 1.0);
  const bool enough =
      !calibrated.places.optima.empty() && calibrated.places.consistent && gain < kUncalibrated;
  if (enough || !h->uncalibrated) *h = std::move(calibrated);
}

int rangesOf(const SurveyData& data, std::size_t anchor) {
  int n = 0;
  for (const SurveyRange& r : data.ranges) n += r.anchor == anchor;
  return n;
}

/// Twice the log of the likelihood ratio to `now`. What `then` leaves out is taken to fit as well
/// as what it keeps.
double evidenceFor(const SurveyHypothesis& now, const SurveyHypothesis& then, double price) {
  const double worth = std::max(1.0, std::min(now.places.worth, then.places.worth));
  const double left_out =
      static_cast<double>(now.places.ranges) - static_cast<double>(then.places.ranges);
  const double each = then.places.raw_cost / std::max(1.0, static_cast<double>(then.places.ranges));
  return 2 * (now.places.raw_cost - then.places.raw_cost - left_out * each) / worth - price;
}

/// Where the ranges of an anchor put it in S, the path lying there as the others say. Empty where
/// that is not known or is where it should be.
std::optional<Vec3> placeOf(const SurveyHypothesis& others, const SurveyData& all,
                            std::size_t anchor) {
  const LevelTransform T_S_W = transformOf(others.data, others.places.optima.front().x);
  std::vector<AntennaRange> ranges;
  for (const SurveyRange& r : all.ranges) {
    if (r.anchor == anchor) ranges.push_back({T_S_W * r.p_W, r.range_m, r.sigma_m});
  }
  AnchorInitOptions o;
  o.min_ranges = kFewestRanges;
  o.bias_sigma_m = others.bias_sigma_m;
  o.drift_ratio = 0;  // in the sigmas already
  o.floor_sigma_m = 0;
  const AnchorInitialization found = initializeAnchor(ranges, o);
  if (found.geometry != AnchorGeometry::good) return std::nullopt;
  const AnchorSolution& s = found.solutions.front();
  const double off = (s.p_W - others.survey[anchor].p_S).norm();
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(s.covariance.topLeftCorner<3, 3>());
  const double sigma = std::sqrt(std::max(eigen.eigenvalues()[2], 0.0));
  if (off < kElsewhere || off < kElsewhereSigmas * sigma) return std::nullopt;
  return s.p_W;
}

/// Are ranges of an anchor shorter than its surveyed place allows? No obstacle makes them so.
bool tooShort(const SurveyHypothesis& others, const SurveyData& all, std::size_t anchor) {
  if (others.places.optima.empty()) return false;
  const LevelTransform T_S_W = transformOf(others.data, others.places.optima.front().x);
  int too_short = 0, ranges = 0;
  for (const SurveyRange& r : all.ranges) {
    if (r.anchor != anchor) continue;
    const double distance = (T_S_W * r.p_W - others.survey[anchor].p_S).norm();
    ++ranges;
    too_short += r.range_m - distance < -kElsewhere - kInlierSigma * r.sigma_m;
  }
  return ranges >= kFewestRanges && too_short > kTooShortShare * ranges;
}

class FaultSearch {
 public:
  explicit FaultSearch(const SurveyMatchOptions& options) : options_(options) {}

  /// All single faults that explain more than `now` does, the likeliest first.
  /// `doubted`: the ranges do not fit it, or only with biases.
  std::vector<Candidate> candidates(const SurveyHypothesis& now, bool doubted) {
    out_.clear();
    std::vector<std::size_t> heard;
    const std::vector<char> in = heardIn(now.data, now.survey.size());
    for (std::size_t a = 0; a < in.size(); ++a) {
      if (in[a]) heard.push_back(a);
    }
    if (heard.size() < 2) return {};
    if (now.findings.empty()) tryUnits(now);
    if (heard.size() < 3) return sorted();
    // An anchor with a place of its own always fits as well.
    doubted = doubted || now.uncalibrated;
    for (const std::size_t a : heard) {
      if (doubted && heard.size() > kFewestAnchors) tryWithout(now, a);
    }
    if (static_cast<int>(heard.size()) > kMostForPairs) return sorted();
    for (std::size_t i = 0; i < heard.size(); ++i) {
      for (std::size_t j = i + 1; j < heard.size(); ++j) tryExchange(now, heard[i], heard[j]);
    }
    return sorted();
  }

 private:
  std::vector<Candidate> sorted() {
    std::stable_sort(out_.begin(), out_.end(), [](const Candidate& a, const Candidate& b) {
      return a.finding.evidence > b.finding.evidence;
    });
    return std::move(out_);
  }
  void keepIfBetter(const SurveyHypothesis& now, SurveyHypothesis then, SurveyFinding finding,
                    double price) {
    evaluateFree(options_, &then);
    if (!believable(then)) return;
    finding.evidence = evidenceFor(now, then, price);
    if (finding.evidence + price > -kApart) out_.push_back({finding, std::move(then)});
  }
  void tryUnits(const SurveyHypothesis& now) {
    for (const double factor : kUnits) {
      SurveyHypothesis then = now;
      for (SurveyedAnchor& a : then.survey) a.p_S *= factor;
      SurveyFinding finding;
      finding.fault = SurveyFault::unit;
      finding.factor = factor;
      keepIfBetter(now, std::move(then), finding, kUnitCost);
    }
  }
  void tryWithout(const SurveyHypothesis& now, std::size_t anchor) {
    if (rangesOf(now.data, anchor) < kFewestToTell) return;
    SurveyHypothesis then = now;
    then.used[anchor] = 0;
    then.data = without(now.data, anchor);
    SurveyFinding finding;
    finding.first = anchor;
    keepIfBetter(now, std::move(then), finding, kElsewhereCost);
  }
  void tryExchange(const SurveyHypothesis& now, std::size_t a, std::size_t b) {
    SurveyHypothesis then = now;
    std::swap(then.survey[a].p_S, then.survey[b].p_S);
    SurveyFinding finding;
    finding.fault = SurveyFault::exchanged;
    finding.first = a;
    finding.second = b;
    keepIfBetter(now, std::move(then), finding, kExchangedCost);
  }

  const SurveyMatchOptions& options_;
  std::vector<Candidate> out_;
};

std::string oneOf(const std::vector<Candidate>& candidates,
                  const std::vector<SurveyedAnchor>& survey) {
  std::string text;
  for (const Candidate& c : candidates) {
    if (c.finding.evidence < candidates.front().finding.evidence - kApart) break;
    const std::string id = std::to_string(survey[c.finding.first].id);
    text += text.empty() ? "" : " or ";
    if (c.finding.fault == SurveyFault::unit) text += "its unit";
    if (c.finding.fault == SurveyFault::elsewhere) text += "the place of " + id;
    if (c.finding.fault == SurveyFault::exchanged) {
      text += id + " exchanged with " + std::to_string(survey[c.finding.second].id);
    }
  }
  return text;
}

/// The next fault is taken in: true. Else nothing explains more than what there is, which may say
/// why it is not to be relied on.
bool takeFault(const SurveyData& data, const SurveyMatchOptions& options, SurveyHypothesis* now) {
  // Biases of boards that are not calibrated explain much that a fault explains as well: with
  // calibrated ones first, against what is believed so far.
  SurveyMatchOptions calibrated = options;
  calibrated.uncalibrated_bias_sigma_m = 0;
  SurveyHypothesis reference = *now;
  if (now->uncalibrated && !believable(*now)) evaluateFree(calibrated, &reference);
  std::vector<Candidate> found = FaultSearch(calibrated).candidates(reference, !believable(*now));
  const bool told = !found.empty() && found.front().finding.evidence > kBelieved;
  if (!told && now->uncalibrated && !believable(*now)) {
    found = FaultSearch(options).candidates(*now, true);
  }
  if (found.empty()) return false;
  Candidate& best = found.front();
  if (best.finding.evidence < kBelieved) {
    if (believable(*now)) now->undecided = oneOf(found, now->survey);
    return false;
  }
  if (found.size() > 1 && found[1].finding.evidence > best.finding.evidence - kApart) {
    now->suspicion = "the ranges contradict the survey; likely wrong: " + oneOf(found, now->survey);
    now->places.consistent = false;
    return false;
  }
  evaluate(options, &best.hypothesis);
  if (best.finding.fault == SurveyFault::elsewhere && !best.hypothesis.places.optima.empty()) {
    best.finding.found_S = placeOf(best.hypothesis, data, best.finding.first);
  }
  // One whose ranges are too long may be hidden for a while: left out, but no fault of the survey.
  const bool is_fault = best.finding.fault != SurveyFault::elsewhere || best.finding.found_S ||
                        tooShort(best.hypothesis, data, best.finding.first);
  if (is_fault) best.hypothesis.findings.push_back(best.finding);
  *now = std::move(best.hypothesis);
  return true;
}

}  // namespace

bool believable(const SurveyHypothesis& h) {
  return h.places.consistent && !h.places.optima.empty() && h.places.bias_spread_m < kBiasSpread;
}

SurveyHypothesis likeliest(const SurveyData& data, const std::vector<SurveyedAnchor>& survey,
                           const SurveyMatchOptions& options) {
  SurveyHypothesis now;
  now.survey = survey;
  now.used.assign(survey.size(), 1);
  now.data = data;
  evaluate(options, &now);
  if (!options.look_for_faults) return now;
  for (int k = 0; k < kMostFaults && (!believable(now) || now.uncalibrated || options.thorough);
       ++k) {
    if (!takeFault(data, options, &now)) break;
  }
  return now;
}

}  // namespace vir::ranging
