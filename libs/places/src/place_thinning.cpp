#include "place_thinning.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>

#include "vir/core/angles.h"

namespace vir::places {
namespace {

/// Keyframes within a cell of position and heading see much the same. [m, rad]
constexpr double kCell_m = 0.5, kCell_rad = kPi / 8;

using Cell = std::array<std::int64_t, 5>;

Cell cellOf(const PlaceKeyframe& k, double scale) {
  const Vec3 ahead = (k.T_W_B * k.T_B_C).q * Vec3::UnitZ();
  const double heading = std::atan2(ahead.y(), ahead.x());
  Cell cell{k.segment, 0, 0, 0, 0};
  const double values[4] = {k.T_W_B.p.x() / kCell_m, k.T_W_B.p.y() / kCell_m,
                            k.T_W_B.p.z() / kCell_m, heading / kCell_rad};
  for (std::size_t axis = 0; axis < 4; ++axis) {
    const double v = std::floor(values[axis] / scale);
    cell[axis + 1] = std::abs(v) < 1e15 ? static_cast<std::int64_t>(v) : 0;
  }
  return cell;
}

}  // namespace

std::vector<bool> redundantPlaces(const std::vector<const PlaceKeyframe*>& keyframes,
                                  std::size_t wanted, std::size_t newest) {
  std::vector<bool> gone(keyframes.size(), false);
  const std::size_t end = keyframes.size() - std::min(newest, keyframes.size());
  wanted = std::min(wanted, end);
  for (double scale = 1; wanted > 0 && scale < 1e12; scale *= 2) {
    std::map<Cell, std::vector<std::size_t>> cells;
    for (std::size_t k = 0; k < end; ++k) {
      if (!gone[k]) cells[cellOf(*keyframes[k], scale)].push_back(k);
    }
    std::size_t fullest = 0;
    for (const auto& [cell, members] : cells) fullest = std::max(fullest, members.size());
    // The fullest cells are levelled; a cell is never emptied, larger ones are tried instead.
    for (std::size_t level = fullest; level > 1 && wanted > 0; --level) {
      for (auto& [cell, members] : cells) {
        if (wanted == 0 || members.size() < level) continue;
        gone[members.back()] = true;
        members.pop_back();
        --wanted;
      }
    }
  }
  for (std::size_t k = 0; k < end && wanted > 0; ++k) {
    if (gone[k]) continue;
    gone[k] = true;
    --wanted;
  }
  return gone;
}

}  // namespace vir::places
