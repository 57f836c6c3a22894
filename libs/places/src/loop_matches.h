#pragma once
/// Two places in level frames, and which of their points are the same corner.
#include <cstddef>
#include <memory>
#include <vector>

#include "vir/places/verify_loop.h"

namespace vir::places {

/// A point of a keyframe in a frame with z up: seen along `ray` from `eye`, 1 / `rho` away.
struct LevelPoint {
  Vec3 ray = Vec3::UnitX();  ///< of unit length
  Vec3 eye = Vec3::Zero();   ///< [m]
  double rho = 0;            ///< [1/m]
  double sigma = 0;          ///< of rho [1/m]; 0: the distance is not known
  const PlacePoint* point = nullptr;
  bool known() const { return sigma > 0; }
};

/// All usable points of a keyframe. The frame's origin is `origin_W`, its axes are W's.
std::vector<LevelPoint> levelPoints(const PlaceKeyframe& keyframe, const Vec3& origin_W);

/// The newer keyframe, and the older one with its neighbours in one frame.
struct LevelPlaces {
  std::vector<LevelPoint> newer;
  std::vector<std::vector<LevelPoint>> older;
};
LevelPlaces levelPlaces(const PlaceKeyframe& newer,
                        const std::vector<std::shared_ptr<const PlaceKeyframe>>& older);

/// Point `newer` is point `older` of keyframe `frame`.
struct PointMatch {
  std::size_t newer = 0, frame = 0, older = 0;
};

/// By descriptors alone: each the best of the other, and clearly better than the second.
std::vector<PointMatch> matchDescriptors(const LevelPlaces& places, const VerifyOptions& options);

/// How many different points of the newer keyframe are in there.
int countNewer(const std::vector<PointMatch>& matches);

}  // namespace vir::places
