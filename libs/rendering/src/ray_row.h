#pragma once
/// Rays side by side, in the form a compiler turns into vector instructions.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "surfaces.h"

namespace vir::rendering {

/// The image is worked on in squares of this size, each with the boxes that may show in it [px].
constexpr int kTile = 16;
constexpr float kFar = 1e9F;

using F3 = std::array<float, 3>;

inline F3 toF3(const Vec3& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

/// A box seen from the camera's place.
struct NearBox {
  F3 low, high;
  float distance = 0;  ///< no point of it is nearer
  int index = 0;
};

/// Unit rays of one row of a square, and what they meet.
struct Row {
  alignas(32) float d[3][kTile];
  alignas(32) float inverse[3][kTile];
  alignas(32) float t[kTile];
  alignas(32) std::int32_t face[kTile];
};

inline void meetRoom(const NearBox& room, Row* r) {
  for (int k = 0; k < kTile; ++k) {
    r->t[k] = kFar;
    r->face[k] = 0;
  }
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const float low = room.low[a], high = room.high[a];
    for (int k = 0; k < kTile; ++k) {
      // Of the two planes the one ahead: the other's t is not positive.
      const float t = std::max(low * r->inverse[axis][k], high * r->inverse[axis][k]);
      const std::int32_t face = 2 * axis + (r->d[axis][k] > 0 ? 1 : 0);
      r->face[k] = t < r->t[k] ? face : r->face[k];
      r->t[k] = std::min(t, r->t[k]);
    }
  }
}

inline void meetBox(const NearBox& box, Row* r) {
  const std::int32_t first = kFacesPerBox * (box.index + 1);
  for (int k = 0; k < kTile; ++k) {
    const float ax = box.low[0] * r->inverse[0][k], bx = box.high[0] * r->inverse[0][k];
    const float ay = box.low[1] * r->inverse[1][k], by = box.high[1] * r->inverse[1][k];
    const float az = box.low[2] * r->inverse[2][k], bz = box.high[2] * r->inverse[2][k];
    const float nx = std::min(ax, bx), ny = std::min(ay, by), nz = std::min(az, bz);
    const float enter = std::max(nx, std::max(ny, nz));
    const float leave = std::min(std::max(ax, bx), std::min(std::max(ay, by), std::max(az, bz)));
    const bool hit = (enter < leave) & (enter > 0) & (enter < r->t[k]);
    // The face looks against the ray: its lower side if the ray goes up.
    const std::int32_t fx = r->d[0][k] > 0 ? 0 : 1;
    const std::int32_t fy = r->d[1][k] > 0 ? 2 : 3;
    const std::int32_t fz = r->d[2][k] > 0 ? 4 : 5;
    const std::int32_t face = enter == nx ? fx : (enter == ny ? fy : fz);
    r->t[k] = hit ? enter : r->t[k];
    r->face[k] = hit ? first + face : r->face[k];
  }
}

inline float farthest(const Row& r) {
  float t = r.t[0];
  for (int k = 1; k < kTile; ++k) t = std::max(t, r.t[k]);
  return t;
}

inline void invert(Row* r) {
  for (int axis = 0; axis < 3; ++axis) {
    for (int k = 0; k < kTile; ++k) {
      const float d = r->d[axis][k];
      r->inverse[axis][k] = 1.0F / (std::abs(d) < 1e-9F ? 1e-9F : d);
    }
  }
}

}  // namespace vir::rendering
