#include "likeness.h"

#include <cmath>

namespace vir::places {
namespace {

/// What differs by fewer bits is the same; patches of two places differ by 128 on the average.
constexpr int kAlikeBits = 70;
/// A corner must be known to lie within this, as seen from the newer keyframe [rad].
constexpr double kDoubt = 0.01;
/// Nothing at the side or behind [cosine].
constexpr double kAhead = 0.1;

}  // namespace

Likeness likeness(const Loop& loop, const PlaceKeyframe& older, const PlaceKeyframe& newer,
                  const LoopFinder::Compare& compare) {
  const Pose T_new_old = newer.T_B_C.inverse() * loop.T_older_newer.inverse() * older.T_B_C;
  const Mat3 R = T_new_old.R();
  std::vector<ExpectedPoint> expected;
  for (const PlacePoint& p : older.points) {
    const double rho = p.inverse_distance, sigma = p.inverse_distance_sigma;
    if (!(rho > 0) || !(sigma > 0)) continue;
    const Vec3 turned = R * p.ray_C.cast<double>();
    const Vec3 ray = (turned + rho * T_new_old.p).normalized();
    const Vec3 nearer = (turned + (rho + sigma) * T_new_old.p).normalized();
    if (!ray.allFinite() || ray.z() < kAhead || !((nearer - ray).norm() <= kDoubt)) continue;
    expected.push_back({ray, p.descriptor});
  }
  Likeness out;
  for (const int bits : compare(expected)) {
    if (bits < 0) continue;
    ++out.in_view;
    out.alike += bits < kAlikeBits ? 1 : 0;
  }
  return out;
}

}  // namespace vir::places
