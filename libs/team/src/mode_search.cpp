#include "mode_search.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "explored_covariance.h"
#include "nlopt_polish.h"
#include "starts.h"

namespace vir::team {
namespace {

constexpr double kSameMinimum = 1e-3;  // [m], of B's path: one minimum reached twice
constexpr double kSameValley = 0.5;    // of `same_solution_m`: likewise, on a part of the ranges
constexpr double kRough = 1e-5;        // change of the cost that ends a refinement not yet final
constexpr int kFirstIterations = 6;
constexpr double kFirstChange = 1e-2;
constexpr int kFewForPolish = 10;

/// What is beyond is no position of a robot, and its square no number to compute with [m].
constexpr double kFarthest = 1e8;
constexpr double kFinest = 1e-9;  // [m], of a standard deviation

/// False for what is not a number too.
template <typename M>
bool within(const M& m, double limit) {
  return (m.array().abs() < limit).all();
}

bool usable(const MutualRange& m) {
  return m.range_m > 0 && m.range_m < kFarthest && m.sigma_m > kFinest && m.sigma_m < kFarthest &&
         within(m.p_A, kFarthest) && within(m.p_B, kFarthest) &&
         within(m.cov_A, kFarthest * kFarthest) && within(m.cov_B, kFarthest * kFarthest);
}

bool usable(const SharedAnchor& a) {
  return within(a.p_A, kFarthest) && within(a.p_B, kFarthest) &&
         within(a.cov_A, kFarthest * kFarthest) && within(a.cov_B, kFarthest * kFarthest);
}

bool usable(const SharedPlaces& s) {
  if (s.places < 1 || !std::isfinite(s.T_A_B.yaw_rad) || !within(s.T_A_B.t_m, kFarthest) ||
      !within(s.centre_B, kFarthest) || !within(s.covariance, kFarthest * kFarthest)) {
    return false;
  }
  const Eigen::SelfAdjointEigenSolver<Mat4> eigen(s.covariance, Eigen::EigenvaluesOnly);
  return eigen.eigenvalues()[0] > kFinest * kFinest;
}

double square(double v) { return v * v; }

constexpr double kLevel = 0.02;  // [m]; a robot that rises by less stays on a floor
constexpr double kOneSided = 3;  // sigmas off the floor from which an anchor's side is known

/// Height of the floor that a robot stays on; none if it does not.
std::optional<double> floorOf(const std::vector<MutualRange>& ranges, Vec3 MutualRange::*p) {
  if (ranges.empty()) return std::nullopt;
  double lowest = (ranges.front().*p).z(), highest = lowest, sum = 0;
  for (const MutualRange& m : ranges) {
    lowest = std::min(lowest, (m.*p).z());
    highest = std::max(highest, (m.*p).z());
    sum += (m.*p).z();
  }
  if (highest - lowest > kLevel) return std::nullopt;
  return sum / static_cast<double>(ranges.size());
}

/// From a floor the ranges to an anchor do not tell on which side of it the anchor is. Whichever
/// side its estimate is on would lift the other robot's world: both are as likely.
void coverBothSides(const std::optional<double>& floor_z, Vec3* p, Mat3* C) {
  const double sigma = std::sqrt(std::max(0.0, (*C)(2, 2)));
  if (!floor_z || sigma < kLookedAt) return;
  const double above = p->z() - *floor_z;
  if (std::abs(above) > kOneSided * sigma) return;
  p->z() = *floor_z;
  (*C)(2, 2) += above * above;
  C->block<2, 1>(0, 2).setZero();
  C->block<1, 2>(2, 0).setZero();
}

class Search {
 public:
  Search(const Evidence& evidence, double needed_margin)
      : evidence_(evidence), needed_margin_(needed_margin) {}

  std::vector<Mode> run(const std::vector<WorldTransform>& hints) {
    search(hints);
    return modes_;
  }

 private:
  void keep(const Mode& mode) {
    if (!std::isfinite(mode.cost) || !mode.x.allFinite()) return;
    for (Mode& m : modes_) {
      if (evidence_.apart(m.x, mode.x) > kSameMinimum) continue;
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
    const bool last = cost.size() == evidence_.ranges.size();
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
      if (mode.cost > lowest + 4 * needed_margin_) continue;
      mode.cost = descend(cost, &mode.x, {40, last ? kExact : kRough});
      keep(mode);
    }
  }

  void search(const std::vector<WorldTransform>& hints) {
    const std::vector<MutualRange> few =
        thinned(evidence_.ranges, evidence_.options.max_search_ranges);
    const EvidenceCost cost = evidence_.cost(few, evidence_.options);
    std::vector<Vec4> starts;
    for (const WorldTransform& hint : hints) starts.push_back(toVector(hint));
    if (evidence_.places) starts.push_back(toVector(evidence_.places->T_A_B));
    refine(cost, starts);
    if (!evidence_.anchors.empty()) refine(cost, startsThroughAnchors(cost));
    if (static_cast<int>(few.size()) >= evidence_.options.min_ranges_without_anchor) {
      refine(cost, startsFromRanges(cost));
    }
    sort();
    if (modes_.empty() || !plausible(fitOf(cost.innovations(modes_.front().x), evidence_.options),
                                     evidence_.options)) {
      refine(cost, startsFromGlobalSearch(cost, evidence_.options.max_global_evaluations));
      sort();
    }
    if (!modes_.empty()) {
      refine(cost, {mirrored(modes_.front().x)});
      sort();
    }
    if (few.size() < evidence_.ranges.size()) descendOnAll();
    polishBest();
  }

  /// At the level at which both robots would move in one plane.
  Vec4 mirrored(Vec4 x) const {
    double level = 0;
    for (const MutualRange& m : evidence_.ranges) level += m.p_A.z() - m.p_B.z();
    x[3] = 2 * level / static_cast<double>(evidence_.ranges.size()) - x[3];
    return x;
  }

  void descendOnAll() {
    const EvidenceCost all = evidence_.cost();
    const std::vector<Mode> coarse = std::exchange(modes_, {});
    for (const Mode& m : coarse) {
      // Those that a part of the ranges rules out need not be looked at again.
      if (m.cost > coarse.front().cost + 2 * needed_margin_) break;
      // Nor those that a few ranges only seem to tell apart: they would crowd out a mirror image.
      const bool known = std::any_of(modes_.begin(), modes_.end(), [&](const Mode& k) {
        return evidence_.apart(k.x, m.x) < kSameValley * evidence_.options.same_solution_m;
      });
      if (known) continue;
      Vec4 x = m.x;
      const double value = descend(all, &x, {modes_.empty() ? 8 : 2, kRough});
      keep({value, x});
      if (modes_.size() >= kMostModes) break;
    }
    sort();
    if (modes_.empty()) return;
    modes_.front().cost = descend(all, &modes_.front().x, {20, kExact});
  }

  void polishBest() {
    const auto n = static_cast<int>(evidence_.ranges.size());
    if (modes_.empty() || n < kFewForPolish || n > evidence_.options.max_polish_ranges) return;
    const EvidenceCost all = evidence_.cost();
    Mode& best = modes_.front();
    const Vec4 sigma = gaussNewtonCovariance(all, best.x).diagonal().cwiseSqrt();
    best.cost =
        polish(all, &best.x, 0.2 * sigma.cwiseMin(kLookedAt), evidence_.options.polish_evaluations);
  }

  const Evidence& evidence_;
  const double needed_margin_;
  std::vector<Mode> modes_;
};

}  // namespace

Evidence::Evidence(const std::vector<MutualRange>& all_ranges,
                   const std::vector<SharedAnchor>& all_anchors, const TransformOptions& how,
                   double share_of_positions, const std::optional<SharedPlaces>& shared_places)
    : options(how), position_share(share_of_positions) {
  if (shared_places && usable(*shared_places)) places = shared_places;
  for (const MutualRange& m : all_ranges) {
    if (usable(m)) ranges.push_back(m);
  }
  std::stable_sort(ranges.begin(), ranges.end(),
                   [](const MutualRange& a, const MutualRange& b) { return a.t < b.t; });
  for (const SharedAnchor& a : all_anchors) {
    if (usable(a)) anchors.push_back(a);
  }
  const auto floor_A = floorOf(ranges, &MutualRange::p_A);
  const auto floor_B = floorOf(ranges, &MutualRange::p_B);
  for (SharedAnchor& a : anchors) {
    coverBothSides(floor_A, &a.p_A, &a.cov_A);
    coverBothSides(floor_B, &a.p_B, &a.cov_B);
  }
}

double Evidence::apart(const Vec4& a, const Vec4& b) const {
  const WorldTransform Ta = fromVector(a), Tb = fromVector(b);
  double most = 0;
  std::vector<Vec3> at;
  if (ranges.empty()) {
    at = {middleOfB()};
  } else {
    at = {ranges.front().p_B, ranges[ranges.size() / 2].p_B, ranges.back().p_B};
  }
  for (const Vec3& p_B : at) most = std::max(most, (Ta * p_B - Tb * p_B).norm());
  return std::max(most, std::abs(wrapAngle(a[0] - b[0])) * options.same_solution_m);
}

Vec3 Evidence::middleOfB() const {
  if (ranges.empty()) return places ? places->centre_B : Vec3(Vec3::Zero());
  Vec3 sum = Vec3::Zero();
  for (const MutualRange& m : ranges) sum += m.p_B;
  return sum / static_cast<double>(ranges.size());
}

double Evidence::spreadOfB() const {
  const Vec3 centre = middleOfB();
  double sum = 0;
  for (const MutualRange& m : ranges) sum += (m.p_B - centre).squaredNorm();
  return std::sqrt(sum / static_cast<double>(ranges.size()));
}

Fit fitOf(const std::vector<Innovation>& innovations, const TransformOptions& options) {
  Fit fit;
  for (const Innovation& i : innovations) {
    const bool off = !(std::abs(i.whitened) <= options.gate_sigma);
    if (off && i.whitened < 0) ++fit.too_short;
    ++(off ? fit.rejected : fit.used);
  }
  return fit;
}

bool plausible(const Fit& fit, const TransformOptions& options) {
  const int n = fit.used + fit.rejected;
  if (fit.used < options.min_inlier_share * n) return false;
  return fit.too_short <= std::max(1.0, options.max_short_share * n) &&
         !(n <= 2 && fit.rejected > 0);
}

Mode byPlaces(const Evidence& evidence) {
  Mode mode{0, toVector(evidence.places->T_A_B)};
  mode.cost = descend(evidence.cost(), &mode.x, {40, kExact});
  return mode;
}

double marginOfPlaces(const EvidenceCost& cost, const Vec4& x) {
  // At best everything else would fit without a residual.
  const double most = square(cost.options().gate_sigma);
  double squares = cost.places().chi2(x);
  for (const Innovation& i : cost.innovations(x)) squares += std::min(square(i.whitened), most);
  for (const SharedAnchor& a : cost.anchors()) {
    squares += std::min(cost.anchorChi2(a, x), cost.options().anchor_chi2);
  }
  return cost.options().places_chi2 - squares;
}

std::vector<Mode> searchModes(const Evidence& evidence, const std::vector<WorldTransform>& hints,
                              double needed_margin) {
  return Search(evidence, needed_margin).run(hints);
}

}  // namespace vir::team
