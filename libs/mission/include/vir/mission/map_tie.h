#pragma once
/// Two robots' maps: how do their worlds lie to one another by what both have seen?
#include <functional>
#include <optional>

#include "vir/mission/loop_closer.h"
#include "vir/mission/mission_map.h"
#include "vir/types/image.h"
#include "vir/types/shared_places.h"

namespace vir::mission {

/// The image of a keyframe (8-bit, one channel, valid until the next call); nothing where there is
/// none any more. Asked in the order of keyframes.
using ImageOfKeyframe = std::function<std::optional<Image>(const PlaceKeyframe&)>;

struct MapTie {
  SharedPlaces shared;  ///< `places` 0: nothing in common; segments are the caller's
  LoopCounts loops;
  long looked = 0;     ///< keyframes of B whose image was there
  long imageless = 0;  ///< and those without, which are not looked for
};

/// B's keyframes are looked for in A's map as a run's are (see LoopFinder), each image compared
/// with what it must show. What is told is a fit to all that was found: keyframes near one another
/// say the same and count once, their scatter is in the covariance. Both maps in worlds with z up.
/// Throws std::runtime_error if the maps are of different cameras, and as LoopOptions::validate().
MapTie tie(const MissionMap& A, const MissionMap& B, const ImageOfKeyframe& image_of,
           const LoopOptions& options);

}  // namespace vir::mission
