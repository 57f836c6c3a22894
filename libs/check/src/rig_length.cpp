/// Depth by two cameras against depth by the motion of one.
#include <algorithm>
#include <cmath>
#include <opencv2/features2d.hpp>
#include <utility>

#include "rig_fit.h"
#include "vir/core/order_statistics.h"

namespace vir::check {
namespace {

/// Closer to the horizon depth is mostly noise.
constexpr double kDepthParallaxPx = 5;
constexpr std::size_t kFewRatios = 8;
/// Of the matches between images of one camera: as many fit its path at least, or the path is that
/// of something else.
constexpr double kOnPath = 0.5;
constexpr TimeNs kLongestStep = 1'500'000'000;
constexpr double kShortestMove_m = 0.02;

/// Along the first ray, where the second lies on its line; empty where it does not, or is too near
/// the horizon. `on_line`: whether it does.
std::optional<double> depth(const std::array<Vec3, 2>& rays, const Pose& T_0_1, double focal_px,
                            bool* on_line) {
  const double sine = std::clamp(offLine(rays, T_0_1), -1.0, 1.0);
  *on_line = focal_px * std::abs(std::asin(sine)) <= kNearLinePx;
  const Vec3 ray1 = T_0_1.R() * rays[1];
  const Vec3 across = rays[0].cross(ray1);
  if (!*on_line || focal_px * across.norm() < kDepthParallaxPx) return std::nullopt;
  const double l0 = T_0_1.p.cross(ray1).dot(across) / across.squaredNorm();
  const double l1 = T_0_1.p.cross(rays[0]).dot(across) / across.squaredNorm();
  if (l0 <= 0 || l1 <= 0) return std::nullopt;
  return l0;
}

}  // namespace

void RigLength::add(Sights sights) {
  if (!last_.descriptors.empty() && !sights.corner_descriptors.empty() &&
      sights.t - last_.t < kLongestStep) {
    Step step{last_.t, sights.t, {}};
    std::vector<cv::DMatch> found;
    cv::BFMatcher(cv::NORM_HAMMING, true)
        .match(last_.descriptors, sights.corner_descriptors, found);
    for (const cv::DMatch& m : found) {
      if (m.distance > kMostBits) continue;
      const auto& both = last_.both[static_cast<std::size_t>(m.queryIdx)];
      step.seen.push_back({both[0], both[1], sights.corners[static_cast<std::size_t>(m.trainIdx)]});
    }
    steps_.push_back(std::move(step));
  }
  last_ = std::move(sights);
}

/// Median of depth by motion over depth by the pair; empty where the step does not tell.
std::optional<double> RigLength::ratioOf(const Step& step,
                                         const std::array<const camera::CameraModel*, 2>& models,
                                         const Pose& T_0_1, const Pose& moved,
                                         double focal_px) const {
  std::vector<double> ratios;
  int on_path = 0, all = 0;
  for (const auto& s : step.seen) {
    Vec3 first, second, later;
    if (!models[0]->unproject(s[0], &first) || !models[1]->unproject(s[1], &second) ||
        !models[0]->unproject(s[2], &later)) {
      continue;
    }
    bool near_line = false, by_pair_near = false;
    const auto by_motion = depth({first, later}, moved, focal_px, &near_line);
    ++all;
    on_path += near_line ? 1 : 0;
    const auto by_pair = depth({first, second}, T_0_1, focal_px, &by_pair_near);
    if (by_motion && by_pair) ratios.push_back(*by_motion / *by_pair);
  }
  if (ratios.size() < kFewRatios || on_path < kOnPath * all) return std::nullopt;
  return medianInPlace(&ratios);
}

RigLength::Result RigLength::compare(const std::array<const camera::CameraModel*, 2>& models,
                                     const Pose& T_B_0, const Pose& T_0_1, double focal_px,
                                     const BodyPath& path) const {
  Result out;
  std::vector<double> logs;
  for (const Step& step : steps_) {
    const auto from = path ? path(step.t0) : std::nullopt;
    const auto to = path ? path(step.t1) : std::nullopt;
    if (!from || !to) continue;
    const Pose moved = (*from * T_B_0).inverse() * (*to * T_B_0);
    if (moved.p.norm() < kShortestMove_m) continue;
    const auto ratio = ratioOf(step, models, T_0_1, moved, focal_px);
    if (ratio) logs.push_back(std::log(*ratio));
  }
  out.steps = static_cast<int>(logs.size());
  if (logs.empty()) return out;
  std::vector<double> ordered = logs;
  const double middle = medianInPlace(&ordered);
  for (double& l : logs) l = std::abs(l - middle);
  constexpr double kSigmaOfMedian = 1.4826 * 1.2533;
  out.times = std::exp(middle);
  out.sigma = out.times * kSigmaOfMedian * medianInPlace(&logs) / std::sqrt(out.steps);
  return out;
}

}  // namespace vir::check
