#pragma once
/// Internal: does an image show what it must if it is of the place that it is taken for?
#include "vir/places/loop_finder.h"

namespace vir::places {

struct Likeness {
  int in_view = 0;  ///< corners of the older keyframe that the newer image must show
  int alike = 0;    ///< and does
};

/// By the older keyframe's corners whose distance is known well enough to say where they must be.
Likeness likeness(const Loop& loop, const PlaceKeyframe& older, const PlaceKeyframe& newer,
                  const LoopFinder::Compare& compare);

}  // namespace vir::places
