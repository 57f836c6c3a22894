#include "vir/ranging/survey_differences.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "vir/core/angles.h"

namespace vir::ranging {
namespace {

using Vec4 = Eigen::Vector4d;  // yaw, and where the path's end is in S
using Mat4 = Eigen::Matrix4d;

constexpr int kYaws = 24, kPlaces = 5, kLevels = 3;  // of the starts
constexpr std::size_t kMostStarts = 12;
constexpr std::size_t kForStarts = 120, kMost = 1500;  // differences that are looked at
constexpr int kIterations = 40;
constexpr double kZeroDistance = 1e-6;  // [m]
constexpr double kSamePlace = 0.3;      // [m]; nearer, two solutions are one
constexpr double kWeakest = 1e-10;
constexpr double kFitting = 4;  // sigmas; and the share of differences that must be within
constexpr double kFittingShare = 0.7;
/// Differences at one place resemble one another: so many count as one.
constexpr double kAlike = 4;

double wrapped(double angle) { return std::remainder(angle, 2 * kPi); }

struct Solution {
  double cost = std::numeric_limits<double>::infinity();
  Vec4 x = Vec4::Zero();
};

class Matcher {
 public:
  Matcher(const std::vector<SurveyDifference>& all, const std::vector<SurveyedAnchor>& survey,
          const SurveyMatchOptions& options)
      : survey_(survey), options_(options) {
    end_W_ = all.back().p_W;
    const std::size_t step = all.size() / kMost + 1;
    double behind = 0;  // length of the path from here to its end
    for (std::size_t i = all.size(); i-- > 0;) {
      if (i + 1 < all.size()) behind += (all[i + 1].p_W - all[i].p_W).norm();
      if (i % step != 0) continue;
      SurveyDifference d = all[i];
      const double of_survey = std::hypot(survey[d.anchor].sigma_m, survey[d.reference].sigma_m);
      d.sigma_m = std::sqrt(kAlike) *
                  std::hypot(std::hypot(d.sigma_m, of_survey), options.drift_ratio * behind);
      used_.push_back(d);
    }
  }

  std::vector<Solution> search() const {
    std::vector<SurveyDifference> few;
    const std::size_t step = used_.size() / kForStarts + 1;
    for (std::size_t i = 0; i < used_.size(); i += step) few.push_back(used_[i]);
    std::vector<Solution> starts;
    for (const Vec3& place : places()) {
      for (int k = 0; k < kYaws; ++k) {
        Vec4 x;
        x << 2 * kPi * k / kYaws - kPi, place;
        starts.push_back({cost(few, x, nullptr, nullptr), x});
      }
    }
    sort(&starts);
    std::vector<Solution> rough;
    for (const Solution& s : starts) {
      if (rough.size() >= kMostStarts) break;
      add(descend(few, s.x), &rough);
    }
    std::vector<Solution> out;
    for (const Solution& s : rough) add(descend(used_, s.x), &out);
    sort(&out);
    return out;
  }

  Mat4 covariance(const Vec4& x) const {
    Mat4 H;
    Vec4 g;
    cost(used_, x, &H, &g);
    H.diagonal().array() += kWeakest;
    const Eigen::SelfAdjointEigenSolver<Mat4> eigen(H);
    return eigen.eigenvectors() *
           eigen.eigenvalues().cwiseMax(kWeakest).cwiseInverse().asDiagonal() *
           eigen.eigenvectors().transpose();
  }

  double shareThatFits(const Vec4& x) const {
    std::size_t fits = 0;
    for (const SurveyDifference& d : used_) {
      fits += std::abs(residual(d, x, nullptr)) < kFitting * d.sigma_m / std::sqrt(kAlike) ? 1 : 0;
    }
    return static_cast<double>(fits) / static_cast<double>(used_.size());
  }

  LevelTransform transform(const Vec4& x) const {
    return {wrapped(x[0]), x.tail<3>() - rotZ(x[0]) * end_W_};
  }
  /// Of (yaw, t) as transform() has them, from that of (yaw, end in S).
  Mat4 moved(const Vec4& x, const Mat4& C) const {
    Mat4 J = Mat4::Identity();
    const Vec3 c = rotZ(x[0]) * end_W_;
    J.block<3, 1>(1, 0) = -Vec3(-c.y(), c.x(), 0);
    return J * C * J.transpose();
  }
  /// Of where a point of S is in W.
  Mat3 inWorld(const Vec4& x, const Mat4& C, const Vec3& p_S) const {
    const Vec3 v = rotZ(-x[0]) * (p_S - x.tail<3>());
    Eigen::Matrix<double, 3, 4> J;
    J.col(0) = Vec3(v.y(), -v.x(), 0);
    J.rightCols<3>() = -rotZ(-x[0]);
    return J * C * J.transpose();
  }

 private:
  static void sort(std::vector<Solution>* list) {
    std::stable_sort(list->begin(), list->end(),
                     [](const Solution& a, const Solution& b) { return a.cost < b.cost; });
  }

  void add(const Solution& s, std::vector<Solution>* list) const {
    if (!std::isfinite(s.cost) || !s.x.allFinite()) return;
    for (Solution& known : *list) {
      const bool turned = std::abs(wrapped(known.x[0] - s.x[0])) > 0.1;
      if (turned || (known.x - s.x).tail<3>().norm() > kSamePlace) continue;
      if (s.cost < known.cost) known = s;
      return;
    }
    list->push_back(s);
  }

  /// Where the path may end: about the anchors, and as far beyond.
  std::vector<Vec3> places() const {
    Vec3 low = survey_.front().p_S, high = low;
    for (const SurveyedAnchor& a : survey_) {
      low = low.cwiseMin(a.p_S);
      high = high.cwiseMax(a.p_S);
    }
    const Vec3 middle = 0.5 * (low + high);
    const double reach = std::max({high.x() - low.x(), high.y() - low.y(), 1.0});
    const double tall = std::max(high.z() - low.z(), 0.2 * reach);
    std::vector<Vec3> out;
    for (int i = 0; i < kPlaces; ++i) {
      for (int j = 0; j < kPlaces; ++j) {
        for (int k = 0; k < kLevels; ++k) {
          const double half_xy = 0.5 * (kPlaces - 1), half_z = 0.5 * (kLevels - 1);
          out.push_back(middle + Vec3(reach * 0.75 * (i - half_xy) / half_xy,
                                      reach * 0.75 * (j - half_xy) / half_xy,
                                      tall * 0.75 * (k - half_z) / half_z));
        }
      }
    }
    return out;
  }

  /// Predicted - measured [m], and its gradient.
  double residual(const SurveyDifference& d, const Vec4& x, Vec4* gradient) const {
    const Vec3 way = rotZ(x[0]) * (d.p_W - end_W_);
    const Vec3 p_S = x.tail<3>() + way;
    const Vec3 to = p_S - survey_[d.anchor].p_S, from = p_S - survey_[d.reference].p_S;
    const double a = to.norm(), b = from.norm();
    if (gradient != nullptr) {
      const Vec3 u = (a > kZeroDistance ? Vec3(to / a) : Vec3(Vec3::Zero())) -
                     (b > kZeroDistance ? Vec3(from / b) : Vec3(Vec3::Zero()));
      *gradient << u.y() * way.x() - u.x() * way.y(), u;
    }
    return a - b - d.difference_m;
  }

  /// -2 log likelihood; an obstacle before either anchor makes the difference longer or shorter:
  /// one heavy tail for both signs.
  double cost(const std::vector<SurveyDifference>& list, const Vec4& x, Mat4* H, Vec4* g) const {
    if (H != nullptr) {
      H->setZero();
      g->setZero();
    }
    const double delta = std::max(options_.robust.nlos_delta, 1.0);
    double sum = 0;
    for (const SurveyDifference& d : list) {
      Vec4 J;
      const double r = residual(d, x, H != nullptr ? &J : nullptr) / d.sigma_m;
      const double tail = 1 + r * r / (delta * delta);
      sum += delta * delta * std::log(tail);
      if (H == nullptr) continue;
      const double w = 1 / (tail * d.sigma_m * d.sigma_m);
      *H += w * J * J.transpose();
      *g += w * r * d.sigma_m * J;
    }
    return sum;
  }

  Solution descend(const std::vector<SurveyDifference>& list, Vec4 x) const {
    Mat4 H, next_H;
    Vec4 g, next_g;
    double now = cost(list, x, &H, &g), damping = 1e-3;
    for (int i = 0; i < kIterations && damping < 1e8; ++i) {
      Mat4 damped = H;
      damped.diagonal() *= 1 + damping;
      damped.diagonal().array() += kWeakest;
      const Vec4 next = x - damped.ldlt().solve(g);
      const double then = next.allFinite() ? cost(list, next, &next_H, &next_g) : now + 1;
      if (!(then <= now)) {
        damping *= 10;
        continue;
      }
      const bool small = now - then < 1e-7 * (1 + now);
      x = next;
      now = then;
      H = next_H;
      g = next_g;
      damping = std::max(0.1 * damping, 1e-9);
      if (small) break;
    }
    return {now, x};
  }

  const std::vector<SurveyedAnchor>& survey_;
  const SurveyMatchOptions& options_;
  Vec3 end_W_ = Vec3::Zero();
  std::vector<SurveyDifference> used_;
};

double longestAxis(const Mat3& C) {
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(C, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, eigen.eigenvalues()[2]));
}

SurveyMatch undecided(SurveyMatch match, SurveyStatus status, const std::string& reason) {
  match.status = status;
  match.reason = reason;
  return match;
}

bool usable(const SurveyDifference& d, std::size_t anchors) {
  return d.anchor < anchors && d.reference < anchors && d.anchor != d.reference &&
         d.p_W.allFinite() && std::isfinite(d.difference_m) && d.sigma_m > 0 &&
         std::isfinite(d.sigma_m);
}

}  // namespace

SurveyMatch matchSurveyByDifferences(const std::vector<SurveyDifference>& differences,
                                     const std::vector<SurveyedAnchor>& survey,
                                     const SurveyMatchOptions& options) {
  SurveyMatch out;
  out.survey = survey;
  out.anchors.resize(survey.size());
  std::vector<SurveyDifference> list;
  std::set<std::size_t> heard;
  for (const SurveyDifference& d : differences) {
    if (!usable(d, survey.size())) continue;
    list.push_back(d);
    heard.insert({d.anchor, d.reference});
  }
  if (heard.size() < 3) {
    return undecided(out, SurveyStatus::waiting,
                     "differences of ranges to three of its anchors are needed, " +
                         std::to_string(heard.size()) + " have been heard");
  }
  if (list.size() < static_cast<std::size_t>(std::max(options.min_ranges, 8))) {
    return undecided(out, SurveyStatus::waiting, "too few differences of ranges yet");
  }
  const Matcher matcher(list, survey, options);
  const std::vector<Solution> found = matcher.search();
  if (found.empty()) return undecided(out, SurveyStatus::waiting, "nothing to start from");
  const Solution& best = found.front();
  const Mat4 C = matcher.covariance(best.x);
  out.T_S_W = matcher.transform(best.x);
  out.covariance = matcher.moved(best.x, C);
  for (std::size_t i = 0; i < survey.size(); ++i) {
    MatchedAnchor& a = out.anchors[i];
    a.used = true;
    a.p_W = out.T_S_W.inverse() * survey[i].p_S;
    a.covariance.topLeftCorner<3, 3>() = matcher.inWorld(best.x, C, survey[i].p_S);
    a.covariance(3, 3) = options.bias_sigma_m * options.bias_sigma_m;
    if (heard.count(i) == 0) continue;
    out.needed_sigma_m =
        std::max(out.needed_sigma_m, longestAxis(a.covariance.topLeftCorner<3, 3>()));
  }
  if (matcher.shareThatFits(best.x) < kFittingShare) {
    return undecided(out, SurveyStatus::contradicted,
                     "the differences of ranges fit no place of the survey: is the reference of "
                     "each the anchor that the recording says, are its places in metres?");
  }
  if (!(out.needed_sigma_m <= options.max_sigma_m)) {
    return undecided(out, SurveyStatus::open,
                     "the path does not tell yet how the survey lies: more motion is needed");
  }
  if (found.size() > 1 && found[1].cost - best.cost < options.mirror_chi2) {
    return undecided(out, SurveyStatus::open,
                     "two places of the survey fit the differences of ranges");
  }
  out.status = SurveyStatus::found;
  return out;
}

}  // namespace vir::ranging
