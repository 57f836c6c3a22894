#include "loop_matches.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "vir/geometry/finite_pose.h"
#include "vir/places/hamming.h"

namespace vir::places {
namespace {

/// A distance cannot be known better than this (relative).
constexpr double kBestDistance = 0.01;
/// A pixel's ray is of unit length; what is not is damaged.
constexpr double kUnit = 0.01;

/// The best and the second best of a row of distances.
struct Nearest {
  int best = std::numeric_limits<int>::max(), second = std::numeric_limits<int>::max();
  std::size_t at = 0;
  void offer(int distance, std::size_t index) {
    if (distance < best) {
      second = best;
      best = distance;
      at = index;
    } else {
      second = std::min(second, distance);
    }
  }
  bool clear(double ratio, int limit) const {
    return best <= limit && (second == std::numeric_limits<int>::max() || best < ratio * second);
  }
};

void matchFrame(const std::vector<LevelPoint>& newer, const std::vector<LevelPoint>& older,
                std::size_t frame, const VerifyOptions& o, std::vector<PointMatch>* out) {
  std::vector<Nearest> of_newer(newer.size()), of_older(older.size());
  for (std::size_t i = 0; i < newer.size(); ++i) {
    for (std::size_t j = 0; j < older.size(); ++j) {
      if (!newer[i].known() && !older[j].known()) continue;  // says nothing of the pose
      const int d = hammingDistance(newer[i].point->descriptor, older[j].point->descriptor);
      of_newer[i].offer(d, j);
      of_older[j].offer(d, i);
    }
  }
  for (std::size_t i = 0; i < newer.size(); ++i) {
    const Nearest& n = of_newer[i];
    if (!n.clear(o.ratio, o.max_distance_bits) || of_older[n.at].at != i) continue;
    out->push_back({i, frame, n.at});
  }
}

}  // namespace

std::vector<LevelPoint> levelPoints(const PlaceKeyframe& keyframe, const Vec3& origin_W) {
  std::vector<LevelPoint> out;
  const Pose T_W_C = keyframe.T_W_B * keyframe.T_B_C;
  if (!isFinite(T_W_C)) return out;
  const Mat3 R_W_C = T_W_C.R();
  const Vec3 eye = T_W_C.p - origin_W;
  for (const PlacePoint& p : keyframe.points) {
    const Vec3 ray_C = p.ray_C.cast<double>();
    if (!(std::abs(ray_C.norm() - 1) < kUnit)) continue;
    LevelPoint l;
    l.ray = R_W_C * ray_C.normalized();
    l.eye = eye;
    l.point = &p;
    const double rho = p.inverse_distance, sigma = p.inverse_distance_sigma;
    if (std::isfinite(rho) && std::isfinite(sigma) && rho > 0 && sigma > 0) {
      l.rho = rho;
      l.sigma = std::max(sigma, kBestDistance * rho);
    }
    out.push_back(l);
  }
  return out;
}

LevelPlaces levelPlaces(const PlaceKeyframe& newer,
                        const std::vector<std::shared_ptr<const PlaceKeyframe>>& older) {
  LevelPlaces out;
  out.newer = levelPoints(newer, newer.T_W_B.p);
  for (const auto& k : older) {
    out.older.push_back(k ? levelPoints(*k, older.front()->T_W_B.p) : std::vector<LevelPoint>());
  }
  return out;
}

std::vector<PointMatch> matchDescriptors(const LevelPlaces& places, const VerifyOptions& options) {
  std::vector<PointMatch> out;
  for (std::size_t f = 0; f < places.older.size(); ++f) {
    matchFrame(places.newer, places.older[f], f, options, &out);
  }
  return out;
}

int countNewer(const std::vector<PointMatch>& matches) {
  std::vector<std::size_t> all;
  for (const PointMatch& m : matches) all.push_back(m.newer);
  std::sort(all.begin(), all.end());
  return static_cast<int>(std::unique(all.begin(), all.end()) - all.begin());
}

}  // namespace vir::places
