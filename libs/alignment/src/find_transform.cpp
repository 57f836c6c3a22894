#include "vir/alignment/find_transform.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

#include "explored_covariance.h"
#include "geometry_check.h"
#include "nlopt_polish.h"
#include "starts.h"

namespace vir {
namespace {

using alignment::EvidenceCost;
using alignment::fromVector;
using alignment::Mat3x4;
using alignment::Mat4;
using alignment::toVector;
using alignment::Vec4;

constexpr double kSameMinimum = 1e-3;  // [m], of B's path: one minimum reached twice
constexpr std::size_t kMostSolutions = 4;
constexpr double kLookedAt = 0.1;  // [m], a standard deviation above which it is not taken as given
constexpr double kExact = 1e-12, kRough = 1e-5;  // changes of the cost that end a refinement
constexpr int kFirstIterations = 6;
constexpr double kFirstChange = 1e-2;
constexpr int kFewForPolish = 10;
constexpr double kRidge = 9;  // rise of the cost between two solutions that are not told apart
constexpr double kHighestRidge = 3;  // [m]
constexpr int kMinForScatter = 20;

struct Mode {
  double cost = 0;
  Vec4 x = Vec4::Zero();
};

bool usable(const MutualRange& m) {
  return std::isfinite(m.range_m) && m.range_m > 0 && std::isfinite(m.sigma_m) && m.sigma_m > 0 &&
         m.p_A.allFinite() && m.p_B.allFinite() && m.cov_A.allFinite() && m.cov_B.allFinite();
}

bool usable(const SharedAnchor& a) {
  return a.p_A.allFinite() && a.p_B.allFinite() && a.cov_A.allFinite() && a.cov_B.allFinite();
}

class Finder {
 public:
  Finder(const std::vector<MutualRange>& ranges, const std::vector<SharedAnchor>& anchors,
         const TransformOptions& options)
      : options_(options) {
    for (const MutualRange& m : ranges) {
      if (usable(m)) ranges_.push_back(m);
    }
    std::stable_sort(ranges_.begin(), ranges_.end(),
                     [](const MutualRange& a, const MutualRange& b) { return a.t < b.t; });
    for (const SharedAnchor& a : anchors) {
      if (usable(a)) anchors_.push_back(a);
    }
    answer_.ranges = static_cast<int>(ranges_.size());
    answer_.ignored = static_cast<int>(ranges.size() - ranges_.size());
    answer_.needed_margin = -2 * std::log(options.false_alarm);
    answer_.margin = std::numeric_limits<double>::infinity();
  }

  TransformAnswer run(const std::vector<WorldTransform>& hints) {
    if (ranges_.empty()) return refuse("no mutual range yet");
    const int n = static_cast<int>(ranges_.size());
    if (anchors_.empty() && n < options_.min_ranges_without_anchor) {
      return refuse(std::to_string(n) + " of the " +
                    std::to_string(options_.min_ranges_without_anchor) +
                    " mutual ranges that are needed without a common anchor");
    }
    search(hints);
    if (modes_.empty()) return refuse("nothing to start from");
    judge();
    return answer_;
  }

 private:
  TransformAnswer refuse(const std::string& reason) {
    answer_.status = TransformStatus::degenerate;
    answer_.reason = reason;
    return answer_;
  }

  /// How far apart two transforms place B's path [m].
  double apart(const Vec4& a, const Vec4& b) const {
    const WorldTransform Ta = fromVector(a), Tb = fromVector(b);
    double most = 0;
    for (const std::size_t k : {std::size_t{0}, ranges_.size() / 2, ranges_.size() - 1}) {
      most = std::max(most, (Ta * ranges_[k].p_B - Tb * ranges_[k].p_B).norm());
    }
    return std::max(most, std::abs(wrapAngle(a[0] - b[0])) * options_.same_solution_m);
  }

  /// Of B's path, in its world.
  Vec3 middle() const {
    Vec3 sum = Vec3::Zero();
    for (const MutualRange& m : ranges_) sum += m.p_B;
    return sum / static_cast<double>(ranges_.size());
  }

  double spreadOfB() const {
    const Vec3 centre = middle();
    double sum = 0;
    for (const MutualRange& m : ranges_) sum += (m.p_B - centre).squaredNorm();
    return std::sqrt(sum / static_cast<double>(ranges_.size()));
  }

  void keep(const Mode& mode) {
    if (!std::isfinite(mode.cost) || !mode.x.allFinite()) return;
    for (Mode& m : modes_) {
      if (apart(m.x, mode.x) > kSameMinimum) continue;
      if (mode.cost < m.cost) m = mode;
      return;
    }
    modes_.push_back(mode);
  }

  void sort() {
    std::stable_sort(modes_.begin(), modes_.end(),
                     [](const Mode& a, const Mode& b) { return a.cost < b.cost; });
  }

  void refine(const EvidenceCost& cost, const std::vector<Vec4>& starts) {
    const bool last = cost.size() == ranges_.size();
    std::vector<Mode> roughly;
    double lowest = modes_.empty() ? std::numeric_limits<double>::infinity() : modes_[0].cost;
    for (const Mode& m : modes_) lowest = std::min(lowest, m.cost);
    for (const Vec4& start : starts) {
      Mode mode{0, start};
      mode.cost = descend(cost, &mode.x, {kFirstIterations, kFirstChange});
      lowest = std::min(lowest, mode.cost);
      roughly.push_back(mode);
    }
    for (Mode& mode : roughly) {
      // A few steps tell which are worth more.
      if (mode.cost > lowest + 4 * answer_.needed_margin) continue;
      mode.cost = descend(cost, &mode.x, {40, last ? kExact : kRough});
      keep(mode);
    }
  }

  void search(const std::vector<WorldTransform>& hints) {
    const std::vector<MutualRange> few = alignment::thinned(ranges_, options_.max_search_ranges);
    const EvidenceCost cost(few, anchors_, options_);
    std::vector<Vec4> starts;
    for (const WorldTransform& hint : hints) starts.push_back(toVector(hint));
    refine(cost, starts);
    if (!anchors_.empty()) refine(cost, startsThroughAnchors(cost));
    if (static_cast<int>(few.size()) >= options_.min_ranges_without_anchor) {
      refine(cost, startsFromRanges(cost));
    }
    sort();
    if (modes_.empty() || !fits(cost, modes_.front().x)) {
      refine(cost, startsFromGlobalSearch(cost, options_.max_global_evaluations));
      sort();
    }
    if (!modes_.empty()) {
      refine(cost, {mirrored(modes_.front().x)});
      sort();
    }
    if (few.size() < ranges_.size()) descendOnAll();
    polishBest();
  }

  /// At the level at which both robots would move in one plane.
  Vec4 mirrored(Vec4 x) const {
    double level = 0;
    for (const MutualRange& m : ranges_) level += m.p_A.z() - m.p_B.z();
    x[3] = 2 * level / static_cast<double>(ranges_.size()) - x[3];
    return x;
  }

  void descendOnAll() {
    const EvidenceCost all(ranges_, anchors_, options_);
    const std::vector<Mode> coarse = std::exchange(modes_, {});
    for (const Mode& m : coarse) {
      // Those that a part of the ranges rules out need not be looked at again.
      if (m.cost > coarse.front().cost + 2 * answer_.needed_margin) break;
      Vec4 x = m.x;
      const double value = descend(all, &x, {modes_.empty() ? 8 : 2, kRough});
      keep({value, x});
      if (modes_.size() >= kMostSolutions) break;
    }
    sort();
    if (modes_.empty()) return;
    modes_.front().cost = descend(all, &modes_.front().x, {20, kExact});
  }

  void polishBest() {
    const auto n = static_cast<int>(ranges_.size());
    if (modes_.empty() || n < kFewForPolish || n > options_.max_polish_ranges) return;
    const EvidenceCost all(ranges_, anchors_, options_);
    Mode& best = modes_.front();
    const Vec4 sigma = covarianceOf(all, best.x).diagonal().cwiseSqrt();
    best.cost = alignment::polish(all, &best.x, 0.2 * sigma.cwiseMin(kLookedAt),
                                  options_.polish_evaluations);
  }

  struct Fit {
    int used = 0, rejected = 0, too_short = 0;
  };
  Fit fitOf(const std::vector<alignment::Innovation>& innovations) const {
    Fit fit;
    for (const auto& i : innovations) {
      const bool off = !(std::abs(i.whitened) <= options_.gate_sigma);
      if (off && i.whitened < 0) ++fit.too_short;
      ++(off ? fit.rejected : fit.used);
    }
    return fit;
  }
  bool plausible(const Fit& fit) const {
    const int n = fit.used + fit.rejected;
    if (fit.used < options_.min_inlier_share * n) return false;
    return fit.too_short <= std::max(1.0, options_.max_short_share * n) &&
           !(n <= 2 && fit.rejected > 0);
  }
  bool fits(const EvidenceCost& cost, const Vec4& x) const {
    return plausible(fitOf(cost.innovations(x)));
  }

  /// What the scatter and the correlation of the whitened residuals say that the model does not.
  double scatterOf(const std::vector<alignment::Innovation>& innovations) const {
    if (static_cast<int>(innovations.size()) < kMinForScatter) return 1;
    double square = 0, product = 0;
    int n = 0, pairs = 0;
    const alignment::Innovation* before = nullptr;
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

  Mat4 covarianceOf(const EvidenceCost& cost, const Vec4& x) const {
    Mat4 H;
    Vec4 g;
    cost.linearise(x, &H, &g);
    H.diagonal().array() += 1 / alignment::kUnknownVariance;
    Mat4 C = H.inverse();
    return 0.5 * (C + C.transpose());
  }

  /// Where the Gauss-Newton covariance is wide it need not be right.
  Mat4 explored(const Mat4& C, const Vec4& x) const {
    const double lever = std::max(0.1, spreadOfB());
    if (C.diagonal().tail<3>().maxCoeff() < kLookedAt * kLookedAt &&
        C(0, 0) * lever * lever < kLookedAt * kLookedAt) {
      return C;
    }
    const std::vector<MutualRange> few = alignment::thinned(ranges_, options_.max_search_ranges);
    return alignment::exploredCovariance(EvidenceCost(few, anchors_, options_), x, C, middle(),
                                         lever);
  }

  void judge() {
    const EvidenceCost cost(ranges_, anchors_, options_);
    const auto innovations = cost.innovations(modes_.front().x);
    const double factor = scatterOf(innovations);
    answer_.variance_factor = factor;
    for (const Mode& m : modes_) {
      if (answer_.solutions.size() >= kMostSolutions) break;
      TransformSolution s;
      s.T_A_B = fromVector(m.x);
      s.cost = m.cost / factor;
      const Fit fit = fitOf(cost.innovations(m.x));
      s.used = fit.used;
      s.rejected = fit.rejected;
      s.too_short = fit.too_short;
      s.anchors_used = cost.anchorsUsed(m.x);
      s.covariance = covarianceOf(cost, m.x);
      if (answer_.solutions.empty()) s.covariance = explored(s.covariance, m.x);
      s.covariance *= factor;
      answer_.solutions.push_back(s);
    }
    mergeNear(cost);
    for (std::size_t i = 1; i < answer_.solutions.size(); ++i) {
      answer_.margin =
          std::min(answer_.margin, answer_.solutions[i].cost - answer_.solutions.front().cost);
    }
    decide(cost);
  }

  /// Solutions that mean the same in practice become one, with a covariance that covers both; so
  /// do mirror images in height with hardly a barrier between them (motion in a plane): then their
  /// middle is the best that can be said.
  void mergeNear(const EvidenceCost& cost) {
    std::vector<TransformSolution> kept;
    for (const TransformSolution& s : answer_.solutions) {
      bool merged = false;
      for (TransformSolution& k : kept) {
        const double distance = apart(toVector(k.T_A_B), toVector(s.T_A_B));
        const bool ridge = oneRidge(cost, k, s);
        if (distance > options_.same_solution_m && !ridge) continue;
        TransformSolution other = s;
        if (ridge) {
          settle(cost, &k);
          settle(cost, &other);
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
  void settle(const EvidenceCost& cost, TransformSolution* s) const {
    Vec4 x = toVector(s->T_A_B);
    s->cost = descend(cost, &x, {40, kExact}) / answer_.variance_factor;
    s->T_A_B = fromVector(x);
  }

  void mergeInto(const TransformSolution& s, bool move, TransformSolution* kept) const {
    Vec4 d = toVector(s.T_A_B) - toVector(kept->T_A_B);
    d[0] = wrapAngle(d[0]);
    const double odds = std::exp(-0.5 * (s.cost - kept->cost)), share = odds / (1 + odds);
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
    Vec4 d = toVector(b.T_A_B) - toVector(a.T_A_B);
    d[0] = wrapAngle(d[0]);
    const double height = std::abs(d[3]);
    d[3] = 0;
    const Vec4 level = toVector(a.T_A_B);
    const double sideways = apart(level, level + d);
    if (sideways > options_.same_solution_m || sideways > height || height > kHighestRidge) {
      return false;
    }
    Vec4 middle = level + 0.5 * d;
    middle[3] = 0.5 * (a.T_A_B.t_m.z() + b.T_A_B.t_m.z());
    const Vec4 up = Vec4::Unit(3);
    const double barrier = descend(cost, &middle, {20, 1e-4, &up}) / answer_.variance_factor;
    return barrier - a.cost < kRidge;
  }

  void decide(const EvidenceCost& cost) {
    const TransformSolution& best = answer_.solutions.front();
    if (!plausible({best.used, best.rejected, best.too_short})) {
      answer_.status = TransformStatus::inconsistent;
      answer_.reason = std::to_string(best.rejected) + " of " + std::to_string(answer_.ranges) +
                       " ranges fit no transform (" + std::to_string(best.too_short) +
                       " too short): outliers, or another robot's";
      return;
    }
    const bool anchored = best.anchors_used > 0;
    if (!anchored && !anchors_.empty() && answer_.ranges < options_.min_ranges_without_anchor) {
      answer_.status = TransformStatus::inconsistent;
      answer_.reason = "the ranges contradict the common anchor";
      return;
    }
    const alignment::GeometryProblem geometry = geometryOf(best, cost);
    if (tooUncertain(best)) {
      answer_.status = TransformStatus::degenerate;
      if (!geometry.reason.empty()) answer_.reason = geometry.reason;
      return;
    }
    // As many measurements as unknowns prove nothing, even where the two yaws coincide.
    const bool proved = answer_.ranges + 3 * best.anchors_used > 4;
    if (answer_.margin >= answer_.needed_margin && proved) {
      answer_.status = TransformStatus::unique;
      answer_.solutions.resize(1);
      return;
    }
    answer_.status = geometry.mirrored && answer_.ranges > 1 ? TransformStatus::degenerate
                                                             : TransformStatus::ambiguous;
    char text[120] = "one range proves nothing";
    if (proved) {
      std::snprintf(text, sizeof text, "two transforms fit (cost differs by %.1f of %.1f)",
                    answer_.margin, answer_.needed_margin);
    }
    answer_.reason = geometry.reason.empty() ? text : geometry.reason;
  }

  alignment::GeometryProblem geometryOf(const TransformSolution& best,
                                        const EvidenceCost& cost) const {
    if (best.anchors_used > 1) return {};  // a baseline of their own
    alignment::GeometryProblem problem;
    for (const SharedAnchor& a : anchors_) {
      const bool used = cost.anchorChi2(a, toVector(best.T_A_B)) < options_.anchor_chi2;
      problem = alignment::geometryProblem(ranges_, &a);
      if (used || !problem.reason.empty()) return problem;
    }
    return alignment::geometryProblem(ranges_, nullptr);
  }

  /// Sets a general reason when it is.
  bool tooUncertain(const TransformSolution& s) {
    const Mat3x4 J = alignment::pointJacobian(rotZ(s.T_A_B.yaw_rad) * middle());
    const Mat3 C = J * s.covariance * J.transpose();
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(C.topLeftCorner<2, 2>(),
                                                         Eigen::EigenvaluesOnly);
    const double horizontal = std::sqrt(std::max(0.0, eigen.eigenvalues()[1]));
    const double yaw = std::sqrt(std::max(0.0, s.covariance(0, 0)));
    char text[160];
    std::snprintf(text, sizeof text,
                  "yaw known to %.2f rad and position to %.2f m only: more motion is needed",
                  std::min(yaw, M_PI), horizontal);
    answer_.reason = text;
    const bool uncertain =
        !(yaw <= options_.max_yaw_sigma_rad) || !(horizontal <= options_.max_sigma_m);
    if (!uncertain) answer_.reason.clear();
    return uncertain;
  }

  const TransformOptions& options_;
  std::vector<MutualRange> ranges_;
  std::vector<SharedAnchor> anchors_;
  std::vector<Mode> modes_;
  TransformAnswer answer_;
};

}  // namespace

TransformAnswer findTransform(const std::vector<MutualRange>& ranges,
                              const std::vector<SharedAnchor>& anchors,
                              const TransformOptions& options,
                              const std::vector<WorldTransform>& hints) {
  return Finder(ranges, anchors, options).run(hints);
}

}  // namespace vir
