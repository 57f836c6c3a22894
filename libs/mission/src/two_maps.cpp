#include "two_maps.h"

#include <memory>
#include <stdexcept>
#include <utility>

namespace vir::mission {
namespace {

/// Between keyframes whose stamps do not rise: of another run than the one before.
constexpr TimeNs kApart = 1000000000;

}  // namespace

TwoMaps::TwoMaps(const MissionMap& first, const MissionMap& second, const LoopOptions& options)
    : second_(second), places_(options) {
  const std::string other = cameraDifference(first.calibration.camera, second.calibration.camera);
  if (!other.empty()) throw std::runtime_error("the maps are of different cameras: " + other);
  if (first.keyframes.empty() || second.keyframes.empty()) {
    throw std::runtime_error("a map without keyframes has no place that could be found");
  }
  for (const auto& k : first.keyframes) places_.remember(*k);
  offset_ = first.keyframes.back()->id + 1 - second.keyframes.front()->id;
}

void TwoMaps::lookForAll(const LookFor& look_for, bool in_first_only) {
  places_.lookInMapOnly(in_first_only);
  TimeNs t = 0;
  for (const auto& k : second_.keyframes) {
    const Look how = look_for ? look_for(*k) : Look();
    auto copy = std::make_shared<PlaceKeyframe>(*k);
    copy->id = idOf(*k);
    const bool rises = k == second_.keyframes.front() || k->t > t;
    t = copy->t = rises ? k->t : t + kApart;
    PathNode node;
    node.id = copy->id;
    node.t = node.segment_since = t;
    node.segment = copy->segment;
    node.T_W_B = copy->T_W_B;
    places_.add(std::move(copy), node, how.look, how.compare);
    if (places_.graph().solveDue()) places_.graph().solve();
  }
  places_.graph().solve();
}

}  // namespace vir::mission
