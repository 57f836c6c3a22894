#include "finder.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

#include "explored_covariance.h"
#include "geometry_check.h"
#include "starts.h"
#include "vir/core/angles.h"

namespace vir::team {
namespace {

constexpr double kRidge = 9;  // rise of the cost between two solutions that are not told apart
/// Distance of the mean from the minimum, as a share of sigma, that makes the mean the answer.
constexpr double kLopsided = 0.2;
constexpr double kHighestRidge = 3;  // [m]
constexpr int kMinForScatter = 20;
constexpr int kMinForSlowShare = 60;
constexpr double kLessLikely = 4;  // cost by which a share of slow errors is worse than another

/// What leads from one solution to another, the shorter way round.
Vec4 between(const TransformSolution& from, const TransformSolution& to) {
  Vec4 d = toVector(to.T_A_B) - toVector(from.T_A_B);
  d[0] = wrapAngle(d[0]);
  return d;
}

/// How likely one of two solutions is, as their costs say.
double shareOf(const TransformSolution& one, const TransformSolution& other) {
  const double odds = std::exp(-0.5 * (one.cost - other.cost));
  return odds / (1 + odds);
}

class Finder {
 public:
  Finder(const Evidence& evidence, std::size_t offered)
      : options_(evidence.options), measured_(evidence.options), evidence_(evidence) {
    answer_.ranges = static_cast<int>(evidence_.ranges.size());
    answer_.ignored = static_cast<int>(offered - evidence_.ranges.size());
    answer_.places = evidence_.places ? evidence_.places->places : 0;
    answer_.needed_margin = -2 * std::log(options_.false_alarm);
    answer_.margin = std::numeric_limits<double>::infinity();
  }

  TransformAnswer run(const std::vector<WorldTransform>& hints) {
    const int n = static_cast<int>(evidence_.ranges.size());
    if (n == 0 && !evidence_.places) return refuse("no mutual range yet");
    if (evidence_.anchors.empty() && !evidence_.places && n < options_.min_ranges_without_anchor) {
      return refuse(std::to_string(n) + " of the " +
                    std::to_string(options_.min_ranges_without_anchor) +
                    " mutual ranges that are needed without a common anchor");
    }
    modes_ = n == 0 ? std::vector<Mode>{byPlaces(evidence_)}
                    : searchModes(evidence_, hints, answer_.needed_margin);
    if (modes_.empty()) return refuse("nothing to start from");
    formAnswer();
    return answer_;
  }

 private:
  TransformAnswer refuse(const std::string& reason) {
    answer_.status = TransformStatus::degenerate;
    answer_.reason = reason;
    return answer_;
  }

  /// What the scatter and the correlation of the whitened residuals say that the model does not.
  double scatterOf(const std::vector<Innovation>& innovations) const {
    if (static_cast<int>(innovations.size()) < kMinForScatter) return 1;
    double square = 0, product = 0;
    int n = 0, pairs = 0;
    const Innovation* before = nullptr;
    for (const auto& i : innovations) {
      const bool in = std::abs(i.whitened) <= options_.gate_sigma;
      if (in) {
        square += i.whitened * i.whitened;
        ++n;
        if (before != nullptr) {
          product += i.whitened * before->whitened;
          ++pairs;
        }
      }
      before = in ? &i : nullptr;
    }
    if (n < kMinForScatter || pairs < kMinForScatter / 2 || !(square > 0)) return 1;
    const double variance = square / n;
    const double rho = std::clamp(product / pairs / variance, 0.0, 0.95);
    // Below two standard deviations a correlation is taken for chance.
    const double grown = rho < 2 / std::sqrt(pairs) ? 1 : (1 + rho) / (1 - rho);
    return std::max(1.0, variance * grown);
  }

  /// How much of the errors is slow is asked of the residuals: the largest share up to `slow_share`
  /// that is about as likely as the likeliest. Only the covariance and the last refinement use it:
  /// the verdict stays with what may be.
  double measuredSlowShare(const Vec4& x) const {
    if (static_cast<int>(evidence_.ranges.size()) < kMinForSlowShare) return options_.slow_share;
    constexpr int kSteps = 4;
    double costs[kSteps + 1];
    TransformOptions tried = options_;
    for (int i = 0; i <= kSteps; ++i) {
      tried.slow_share = options_.slow_share * i / kSteps;
      costs[i] = evidence_.cost(evidence_.ranges, tried)(x);
    }
    const double limit = *std::min_element(costs, costs + kSteps + 1) + kLessLikely;
    int i = kSteps;
    while (!(costs[i] <= limit) && i > 0) --i;
    return options_.slow_share * i / kSteps;
  }

  /// Where the Gauss-Newton covariance is wide it need not be right.
  Mat4 explored(const Mat4& C, const Vec4& x) const {
    const double lever = std::max(0.1, evidence_.spreadOfB());
    if (C.diagonal().tail<3>().maxCoeff() < kLookedAt * kLookedAt &&
        C(0, 0) * lever * lever < kLookedAt * kLookedAt) {
      return C;
    }
    const std::vector<MutualRange> few = thinned(evidence_.ranges, options_.max_search_ranges);
    return exploredCovariance(evidence_.cost(few, measured_), x, C, evidence_.middleOfB(), lever);
  }

  /// A height that is hardly known is told by its mean, not by the end of a ridge.
  void averageHeight(const Vec4& x, TransformSolution* s) {
    const double sigma = std::sqrt(s->covariance(3, 3));
    if (!(sigma > kLookedAt)) return;
    const std::vector<MutualRange> few = thinned(evidence_.ranges, options_.max_search_ranges);
    const EvidenceCost cost = evidence_.cost(few, measured_);
    const HeightMean mean = heightMean(cost, x, sigma);
    const double moved = mean.x[3] - x[3];
    Vec4 level = mean.x;
    level[3] = x[3];
    // Where the cost is nearly a parabola its minimum is the better answer.
    if (std::abs(moved) < kLopsided * std::sqrt(mean.variance)) return;
    if (std::abs(moved) > kHighestRidge || evidence_.apart(x, level) > options_.same_solution_m) {
      return;
    }
    s->T_A_B = fromVector(mean.x);
    s->covariance(3, 3) = std::max(mean.variance, s->covariance(3, 3) - moved * moved);
    averaged_ = true;
  }

  void formAnswer() {
    const EvidenceCost cost = evidence_.cost();
    const auto innovations = cost.innovations(modes_.front().x);
    const double factor = scatterOf(innovations);
    answer_.variance_factor = factor;
    measured_.slow_share = measuredSlowShare(modes_.front().x);
    const EvidenceCost measured = evidence_.cost(evidence_.ranges, measured_);
    if (measured_.slow_share < options_.slow_share) {
      descend(measured, &modes_.front().x, {20, 1e-6});
      modes_.front().cost = cost(modes_.front().x);
    }
    for (const Mode& m : modes_) {
      if (answer_.solutions.size() >= kMostModes) break;
      TransformSolution s;
      s.T_A_B = fromVector(m.x);
      // How the ranges scatter tells nothing of the places.
      const double of_places = cost.places().add(m.x, nullptr, nullptr);
      s.cost = (m.cost - of_places) / factor + of_places;
      s.places_used = cost.places().used(m.x) ? answer_.places : 0;
      const Fit fit = fitOf(cost.innovations(m.x), options_);
      s.used = fit.used;
      s.rejected = fit.rejected;
      s.too_short = fit.too_short;
      s.anchors_used = cost.anchorsUsed(m.x);
      s.covariance = gaussNewtonCovariance(measured, m.x);
      if (answer_.solutions.empty() && answer_.ranges > 0) {
        s.covariance = explored(s.covariance, m.x);
        averageHeight(m.x, &s);
      }
      s.covariance *= factor;
      answer_.solutions.push_back(s);
    }
    mergeNear(cost);
    for (std::size_t i = 1; i < answer_.solutions.size(); ++i) {
      answer_.margin =
          std::min(answer_.margin, answer_.solutions[i].cost - answer_.solutions.front().cost);
    }
    // With so few ranges nobody has looked where the worlds lie if the places only look alike.
    const TransformSolution& best = answer_.solutions.front();
    if (best.places_used > 0 && answer_.ranges < options_.min_ranges_without_anchor) {
      answer_.margin = std::min(answer_.margin, marginOfPlaces(cost, toVector(best.T_A_B)));
    }
    decide(cost);
  }

  /// Solutions that mean the same in practice become one, with a covariance that covers both; so
  /// do mirror images in height (motion in a plane): then their middle is the best that can be
  /// said.
  void mergeNear(const EvidenceCost& cost) {
    std::vector<TransformSolution> kept;
    for (const TransformSolution& s : answer_.solutions) {
      bool merged = false;
      for (TransformSolution& k : kept) {
        const double distance = evidence_.apart(toVector(k.T_A_B), toVector(s.T_A_B));
        const bool ridge = oneRidge(cost, k, s);
        if (distance > options_.same_solution_m && !ridge) {
          if (!onlyHeightOpen(k, s)) continue;
          spanHeights(s, &k);
          merged = true;
          break;
        }
        TransformSolution other = s;
        // The mean is there already.
        if (ridge && averaged_ && kept.size() == 1) {
          merged = true;
          break;
        }
        if (ridge) {
          descendToMinimum(cost, &k);
          descendToMinimum(cost, &other);
        }
        mergeInto(other, ridge, &k);
        merged = true;
        break;
      }
      if (!merged) kept.push_back(s);
    }
    answer_.solutions = kept;
  }

  /// To the very minimum, as the middle is taken.
  void descendToMinimum(const EvidenceCost& cost, TransformSolution* s) const {
    Vec4 x = toVector(s->T_A_B);
    s->cost = descend(cost, &x, {40, kExact}) / answer_.variance_factor;
    s->T_A_B = fromVector(x);
  }

  void mergeInto(const TransformSolution& s, bool move, TransformSolution* kept) const {
    const Vec4 d = between(*kept, s);
    const double share = shareOf(s, *kept);
    if (move) {
      kept->T_A_B = fromVector(toVector(kept->T_A_B) + share * d);
      // The walks that explored the covariance started from one end of the ridge.
      kept->covariance(3, 3) = std::max(kept->covariance(3, 3) - share * share * d[3] * d[3],
                                        share * (1 - share) * d[3] * d[3]);
    } else {
      kept->covariance += share * d * d.transpose();
    }
  }

  /// Apart in height only, and the cost in the middle is hardly higher.
  bool oneRidge(const EvidenceCost& cost, const TransformSolution& a,
                const TransformSolution& b) const {
    Vec4 d = between(a, b);
    const double height = std::abs(d[3]);
    d[3] = 0;
    const Vec4 level = toVector(a.T_A_B);
    const double sideways = evidence_.apart(level, level + d);
    if (sideways > options_.same_solution_m || sideways > height || height > kHighestRidge) {
      return false;
    }
    Vec4 middle = level + 0.5 * d;
    middle[3] = 0.5 * (a.T_A_B.t_m.z() + b.T_A_B.t_m.z());
    const Vec4 up = Vec4::Unit(3);
    const double barrier = descend(cost, &middle, {20, 1e-4, &up}) / answer_.variance_factor;
    return barrier - a.cost < kRidge;
  }

  /// Neither is ruled out, and they agree in all but the height.
  bool onlyHeightOpen(const TransformSolution& a, const TransformSolution& b) const {
    if (b.cost - answer_.solutions.front().cost > answer_.needed_margin) return false;
    const Vec4 va = toVector(a.T_A_B);
    Vec4 level = toVector(b.T_A_B);
    level[3] = va[3];
    return evidence_.apart(va, level) <= options_.same_solution_m;
  }

  /// `kept` becomes the mean of both, each as likely as its cost says, and its covariance is theirs
  /// together: at least so wide that neither lies farther off than two standard deviations.
  void spanHeights(const TransformSolution& s, TransformSolution* kept) {
    const Vec4 d = between(*kept, s);
    const double share = shareOf(s, *kept);
    if (!kept->likelier_z_m) {
      kept->likelier_z_m = (share > 0.5 ? s : *kept).T_A_B.t_m.z();
    }
    kept->T_A_B = fromVector(toVector(kept->T_A_B) + share * d);
    kept->covariance += share * (1 - share) * d * d.transpose();
    const double farthest = std::max(share, 1 - share) * std::abs(d[3]);
    kept->covariance(3, 3) = std::max(kept->covariance(3, 3), 0.25 * farthest * farthest);
    if (kept->cost == answer_.solutions.front().cost) answer_.height_open = true;
  }

  void decide(const EvidenceCost& cost) {
    const TransformSolution& best = answer_.solutions.front();
    const double height_sigma = std::sqrt(std::max(0.0, best.covariance(3, 3)));
    answer_.height_open = answer_.height_open || !(height_sigma <= options_.max_sigma_m);
    if (!plausible({best.used, best.rejected, best.too_short}, options_)) {
      answer_.status = TransformStatus::inconsistent;
      answer_.reason = std::to_string(best.rejected) + " of " + std::to_string(answer_.ranges) +
                       " ranges fit no transform (" + std::to_string(best.too_short) +
                       " too short): outliers, or another robot's";
      return;
    }
    const bool anchored = best.anchors_used > 0 || best.places_used > 0;
    if (!anchored && !evidence_.anchors.empty() &&
        answer_.ranges < options_.min_ranges_without_anchor) {
      answer_.status = TransformStatus::inconsistent;
      answer_.reason = "the ranges contradict the common anchor";
      return;
    }
    const GeometryProblem geometry = geometryOf(best, cost);
    if (tooUncertain(best)) {
      answer_.status = TransformStatus::degenerate;
      if (!geometry.reason.empty()) answer_.reason = geometry.reason;
      return;
    }
    // As many measurements as unknowns prove nothing, even where the two yaws coincide.
    const bool proved = best.places_used > 0 || answer_.ranges + 3 * best.anchors_used > 4;
    if (answer_.margin >= answer_.needed_margin && proved) {
      answer_.status = TransformStatus::unique;
      answer_.solutions.resize(1);
      return;
    }
    answer_.status = geometry.mirrored && answer_.ranges > 1 ? TransformStatus::degenerate
                                                             : TransformStatus::ambiguous;
    dropRuledOut();
    char text[120] = "one range proves nothing";
    if (proved) {
      std::snprintf(text, sizeof text, "two transforms fit (cost differs by %.1f of %.1f)",
                    answer_.margin, answer_.needed_margin);
    }
    if (best.places_used > 0 && answer_.solutions.size() == 1) {
      std::snprintf(text, sizeof text, "the %d places that both have seen fit the rest badly",
                    answer_.places);
    }
    answer_.reason = geometry.reason.empty() ? text : geometry.reason;
  }

  /// What the evidence rules out is no alternative.
  void dropRuledOut() {
    auto& list = answer_.solutions;
    const double limit = list.front().cost + answer_.needed_margin;
    list.erase(std::remove_if(list.begin(), list.end(),
                              [&](const TransformSolution& s) { return s.cost > limit; }),
               list.end());
  }

  GeometryProblem geometryOf(const TransformSolution& best, const EvidenceCost& cost) const {
    if (best.anchors_used > 1 || best.places_used > 0) return {};  // a baseline of their own
    GeometryProblem problem;
    for (const SharedAnchor& a : evidence_.anchors) {
      const bool used = cost.anchorChi2(a, toVector(best.T_A_B)) < options_.anchor_chi2;
      problem = geometryProblem(evidence_.ranges, &a);
      if (used || !problem.reason.empty()) return problem;
    }
    return geometryProblem(evidence_.ranges, nullptr);
  }

  /// Sets a general reason when it is.
  bool tooUncertain(const TransformSolution& s) {
    const Mat3x4 J = pointJacobian(rotZ(s.T_A_B.yaw_rad) * evidence_.middleOfB());
    const Mat3 C = J * s.covariance * J.transpose();
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(C.topLeftCorner<2, 2>(),
                                                         Eigen::EigenvaluesOnly);
    const double horizontal = std::sqrt(std::max(0.0, eigen.eigenvalues()[1]));
    const double yaw = std::sqrt(std::max(0.0, s.covariance(0, 0)));
    char text[160];
    std::snprintf(text, sizeof text,
                  "yaw known to %.2f rad and position to %.2f m only: more motion is needed",
                  std::min(yaw, kPi), horizontal);
    answer_.reason = text;
    const bool uncertain =
        !(yaw <= options_.max_yaw_sigma_rad) || !(horizontal <= options_.max_sigma_m);
    if (!uncertain) answer_.reason.clear();
    return uncertain;
  }

  const TransformOptions& options_;
  TransformOptions measured_;  // with the share of slow errors that the residuals show
  bool averaged_ = false;      // the first solution is the mean along its height
  const Evidence& evidence_;
  std::vector<Mode> modes_;
  TransformAnswer answer_;
};

}  // namespace

TransformAnswer findAsSaid(const Evidence& evidence, std::size_t offered,
                           const std::vector<WorldTransform>& hints) {
  return Finder(evidence, offered).run(hints);
}

}  // namespace vir::team
