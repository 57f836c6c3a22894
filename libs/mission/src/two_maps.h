#pragma once
/// Internal: two maps in one graph. The first one's keyframes stay; the second is another path.
#include <cstdint>
#include <functional>

#include "place_graph.h"
#include "vir/mission/mission_map.h"

namespace vir::mission {

class TwoMaps {
 public:
  /// Throws std::runtime_error if the maps are of different cameras, or one is without keyframes.
  /// Both must live as long as this.
  TwoMaps(const MissionMap& first, const MissionMap& second, const LoopOptions& options);

  /// Should this keyframe of the second be looked for, and how is its image compared?
  struct Look {
    bool look = true;
    places::LoopFinder::Compare compare;
  };
  using LookFor = std::function<Look(const PlaceKeyframe&)>;
  /// Looks for all keyframes of the second. `in_first_only`: not for its own second visits.
  void lookForAll(const LookFor& look_for, bool in_first_only);

  /// Of a keyframe of the second, in graph().
  std::uint64_t idOf(const PlaceKeyframe& k) const { return offset_ + k.id; }
  const MissionGraph& graph() const { return places_.graph(); }
  const places::LoopFinder& finder() const { return places_.finder(); }

 private:
  const MissionMap& second_;
  PlaceGraph places_;
  std::uint64_t offset_;
};

}  // namespace vir::mission
