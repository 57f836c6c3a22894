#pragma once
/// Which keyframes can be forgotten because others show the same.
#include <cstddef>
#include <vector>

#include "vir/types/loop.h"

namespace vir::places {

/// Marks `wanted` keyframes (fewer if there are fewer) of all but the `newest` last ones: those
/// that look from where and whither most others look. Of alike ones the older stay.
std::vector<bool> redundantPlaces(const std::vector<const PlaceKeyframe*>& keyframes,
                                  std::size_t wanted, std::size_t newest);

}  // namespace vir::places
