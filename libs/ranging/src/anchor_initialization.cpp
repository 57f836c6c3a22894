#include "vir/ranging/anchor_initialization.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "anchor_search.h"

namespace vir::ranging {
namespace {

/// Squared Mahalanobis distance of the solution from the prior at which they contradict.
constexpr double kPriorContradicted = 25;
/// A position that explains fewer of the newest ranges is of no use now.
constexpr double kNewestShare = 0.3;
/// Path lengths below this add nothing to a sigma, but keep it positive [m].
constexpr double kLeastSigma = 1e-6;
/// Nearer than this [m] the curvature of the range is no help.
constexpr double kLeastDistance = 0.1;
/// A path goes so far out of its plane at most, as a share of its width in it, on a floor; the
/// cosine of the angle within which the plane is level; and where nothing is known [m].
constexpr double kLevel = 0.1, kUpright = 0.95, kAnywhereSigma = 1e4;

std::string format(const char* pattern, double a, double b = 0, double c = 0) {
  char text[256];
  std::snprintf(text, sizeof text, pattern, a, b, c);
  return text;
}

void checkPrior(const AnchorPrior& prior) {
  const bool finite = prior.p_W.allFinite() && prior.covariance.allFinite();
  if (finite && Eigen::LLT<Mat3>(prior.covariance).info() == Eigen::Success) return;
  throw std::invalid_argument(
      "the position prior of an anchor is not finite or its covariance not positive definite: give "
      "a position and standard deviations above 0");
}

FitData validRanges(const std::vector<AntennaRange>& ranges, double drift_ratio, int* ignored) {
  FitData data;
  // From the newest back: the path is best known where it ends.
  double travelled = 0;
  const Vec3* newer = nullptr;
  for (auto it = ranges.rbegin(); it != ranges.rend(); ++it) {
    const bool valid = it->p_W.allFinite() && std::isfinite(it->range_m) && it->range_m > 0 &&
                       std::isfinite(it->sigma_m) && it->sigma_m > 0 && it->range_m < 1e5 &&
                       it->p_W.norm() < 1e7;
    if (!valid) {
      ++*ignored;
      continue;
    }
    if (newer) travelled += (*newer - it->p_W).norm();
    newer = &it->p_W;
    data.p.push_back(it->p_W);
    data.z.push_back(it->range_m);
    data.drift.push_back(drift_ratio * travelled);
    data.sigma.push_back(std::max(std::hypot(it->sigma_m, data.drift.back()), kLeastSigma));
  }
  std::reverse(data.p.begin(), data.p.end());
  std::reverse(data.z.begin(), data.z.end());
  std::reverse(data.sigma.begin(), data.sigma.end());
  std::reverse(data.drift.begin(), data.drift.end());
  return data;
}

/// Who moves on a floor seldom has anchors far above it.
std::optional<AnchorPrior> floorUnder(const PathShape& path, double sigma_m) {
  const bool level =
      path.deviation[2] < kLevel * path.deviation[1] && std::abs(path.axes(2, 2)) > kUpright;
  if (!level || !(sigma_m > 0)) return std::nullopt;
  AnchorPrior floor;
  floor.p_W = path.centre;
  floor.covariance = Mat3::Identity() * kAnywhereSigma * kAnywhereSigma;
  const Vec3 up = path.axes.col(2);
  floor.covariance += (sigma_m * sigma_m - kAnywhereSigma * kAnywhereSigma) * up * up.transpose();
  return floor;
}

/// Semi-axes of the position's ellipsoid and the direction of the longest.
struct Uncertainty {
  double largest, second, distance;
  Vec3 weakest;
  Uncertainty(const AnchorSolution& s, const Vec3& centre) : distance((s.p_W - centre).norm()) {
    const Eigen::SelfAdjointEigenSolver<Mat3> eigen(s.covariance.topLeftCorner<3, 3>());
    largest = std::sqrt(std::max(eigen.eigenvalues()[2], 0.0));
    second = std::sqrt(std::max(eigen.eigenvalues()[1], 0.0));
    weakest = eigen.eigenvectors().col(2);
  }
  /// Across the line of sight an offset s changes the range by s^2/(2 distance) only, so that the
  /// longest axis may be long without doing harm.
  double neededSigma() const {
    return std::max(second, largest * largest / std::max(distance, kLeastDistance));
  }
};

std::string wayOut(const Vec3& direction) {
  return std::abs(direction.z()) > 0.7 ? "change height" : "move sideways";
}

void classifyGeometry(const AnchorInitOptions& options, const AnchorSearch& search,
                      const std::vector<Optimum>& optima, AnchorInitialization* result) {
  const std::vector<AnchorSolution>& s = result->solutions;
  const Uncertainty best(s.front(), search.shape().centre);
  result->needed_sigma_m = 0;
  for (const AnchorSolution& a : s) {
    const Uncertainty u(a, search.shape().centre);
    result->needed_sigma_m = std::max(result->needed_sigma_m, u.neededSigma());
  }
  const bool usable = result->needed_sigma_m <= options.max_sigma_m;
  const double extent = search.shape().extent[0];
  const bool ring = search.ringFits(optima.front());
  if (optima.size() == 1 && usable && !ring) {
    result->geometry = AnchorGeometry::good;
    if (best.largest > options.max_sigma_m) {
      result->advice =
          wayOut(best.weakest) + format(": one direction is known to %.1f m only", best.largest);
    }
    return;
  }
  // Two points mirrored at the line of a straight path are as much part of a ring as any other.
  if (ring) {
    const double ratio = extent / std::max(best.distance, 1e-9);
    const bool line = search.shape().deviation[1] < 0.2 * search.shape().deviation[0];
    result->geometry = line ? AnchorGeometry::straight_line : AnchorGeometry::too_short;
    result->advice =
        line ? "move sideways: on a straight path a ring of positions fits the ranges"
             : format("move further: %.1f m of motion is too little at %.1f m (%.0f %%)", extent,
                      best.distance, 100 * ratio);
    return;
  }
  if (optima.size() == 2 && usable) {
    result->geometry = AnchorGeometry::mirror;
    const Vec3 between = s[1].p_W - s[0].p_W;
    result->advice =
        wayOut(between.normalized()) +
        format(": two positions %.1f m apart fit, mirrored at the plane of motion", between.norm());
    return;
  }
  if (best.second > options.max_sigma_m) {
    result->geometry = AnchorGeometry::too_short;
    result->advice = format("move further: %.1f m of motion at %.1f m leaves %.1f m of uncertainty",
                            extent, best.distance, best.largest);
    return;
  }
  result->geometry = AnchorGeometry::poor;
  result->advice =
      wayOut(best.weakest) + format(": one direction is known to %.1f m only", best.largest);
}

/// True if no fixed position explains the ranges (or the prior).
bool inconsistent(const AnchorInitOptions& options, const std::optional<AnchorPrior>& prior,
                  const AnchorSearch& search, AnchorInitialization* result) {
  const double valid = result->used + result->outliers;
  const double share = 1 - result->outliers / valid;
  if (result->rms_ratio > options.max_rms_ratio || share < options.min_inlier_share ||
      search.tooShort() > options.max_short_share * valid) {
    result->advice = format(
        "residuals are %.1f times their sigma and %.0f %% of the ranges fit: is the anchor fixed, "
        "its id right, the path good?",
        result->rms_ratio, 100 * share);
    return true;
  }
  if (valid >= options.min_ranges && search.newestShare() < kNewestShare) {
    result->advice =
        format("only %.0f %% of the newest ranges fit: the anchor has moved, or is hidden",
               100 * search.newestShare());
    return true;
  }
  if (!prior || result->solutions.empty()) return false;
  const Vec3 off = result->solutions.front().p_W - prior->p_W;
  const double chi2 = off.dot(prior->covariance.inverse() * off);
  if (chi2 <= kPriorContradicted) return false;
  result->advice = format("the ranges put the anchor %.1f m from its prior, %.1f sigma", off.norm(),
                          std::sqrt(chi2));
  return true;
}

/// `given`: what the caller knows, which ranges may contradict; `assumed`: what the solution rests
/// on.
void search(const FitData& data, const AnchorInitOptions& options,
            const std::optional<AnchorPrior>& given, const std::optional<AnchorPrior>& assumed,
            AnchorInitialization* result) {
  AnchorSearch search(data, options, assumed);
  const std::vector<Optimum> optima = search.run();
  if (optima.empty()) {
    result->geometry = AnchorGeometry::poor;
    result->advice = "move further: no position fits the ranges";
    return;
  }
  for (std::size_t i = 0; i < optima.size() && i < 2; ++i) {
    result->solutions.push_back(search.solution(optima[i]));
  }
  result->outliers = search.tooLong() + search.tooShort();
  result->used = static_cast<int>(data.size()) - result->outliers;
  result->rms_ratio = search.scale();
  result->variance_factor = search.scale() * search.scale() * search.worth();
  if (inconsistent(options, given, search, result)) {
    result->geometry = AnchorGeometry::inconsistent;
    return;
  }
  classifyGeometry(options, search, optima, result);
  if (result->geometry == AnchorGeometry::good) result->solutions.resize(1);
}

}  // namespace

const char* name(AnchorGeometry geometry) {
  switch (geometry) {
    case AnchorGeometry::good:
      return "good";
    case AnchorGeometry::mirror:
      return "mirror";
    case AnchorGeometry::too_short:
      return "too_short";
    case AnchorGeometry::straight_line:
      return "straight_line";
    case AnchorGeometry::poor:
      return "poor";
    case AnchorGeometry::inconsistent:
      return "inconsistent";
  }
  return "unknown";
}

AnchorInitialization initializeAnchor(const std::vector<AntennaRange>& ranges,
                                      const AnchorInitOptions& options,
                                      const std::optional<AnchorPrior>& prior) {
  if (prior) checkPrior(*prior);
  AnchorInitialization result;
  const FitData data = validRanges(ranges, options.drift_ratio, &result.ignored);
  const int n = static_cast<int>(data.size());
  if (n == 0 || (!prior && n < options.min_ranges)) {
    result.advice = format("wait: %.0f of %.0f ranges so far", n, std::max(options.min_ranges, 1));
    return result;
  }
  const PathShape path = pathShape(data.p);
  if (!prior && path.extent[0] < options.min_extent_m) {
    result.advice = format("move further: %.2f m of motion so far, at least %.2f m are needed",
                           path.extent[0], options.min_extent_m);
    return result;
  }
  search(data, options, prior, prior, &result);
  if (prior || result.geometry != AnchorGeometry::poor) return result;
  const std::optional<AnchorPrior> floor = floorUnder(path, options.floor_sigma_m);
  if (!floor) return result;
  AnchorInitialization on_floor;
  on_floor.ignored = result.ignored;
  on_floor.floor = floor;
  search(data, options, prior, floor, &on_floor);
  const bool usable =
      on_floor.geometry == AnchorGeometry::good || on_floor.geometry == AnchorGeometry::mirror;
  return usable ? on_floor : result;
}

}  // namespace vir::ranging
