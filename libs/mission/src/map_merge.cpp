#include "vir/mission/map_merge.h"

#include <algorithm>
#include <map>
#include <stdexcept>

#include "two_maps.h"

namespace vir::mission {
namespace {

/// The same image, described alike.
bool same(const PlaceKeyframe& a, const PlaceKeyframe& b) {
  return a.t == b.t && std::equal(a.points.begin(), a.points.end(), b.points.begin(),
                                  b.points.end(), [](const PlacePoint& p, const PlacePoint& q) {
                                    return p.px == q.px && p.descriptor == q.descriptor;
                                  });
}

/// Keyframes by their time, to find those of one map in the other.
class Known {
 public:
  explicit Known(const MissionMap& map) {
    for (const auto& k : map.keyframes) at_.emplace(k->t, k.get());
  }
  bool has(const PlaceKeyframe& k) const {
    const auto [begin, end] = at_.equal_range(k.t);
    return std::any_of(begin, end, [&](const auto& other) { return same(k, *other.second); });
  }

 private:
  std::multimap<TimeNs, const PlaceKeyframe*> at_;
};

}  // namespace

MergedMaps merge(const MissionMap& first, const MissionMap& second, const LoopOptions& options) {
  options.validate();
  TwoMaps both(first, second, options);
  const Known known(first);
  if (std::all_of(second.keyframes.begin(), second.keyframes.end(),
                  [&](const auto& k) { return known.has(*k); })) {
    return {first, {}, static_cast<long>(second.keyframes.size())};
  }
  both.lookForAll({}, false);
  if (!both.graph().joined()) {
    throw std::runtime_error("no place of the one map was found in the other");
  }

  int segments = 0;
  for (const auto& k : first.keyframes) segments = std::max(segments, k->segment + 1);
  MergedMaps out{first, both.graph().counts(), 0};
  std::vector<LevelPair> pairs;
  for (const auto& k : second.keyframes) {
    auto copy = std::make_shared<PlaceKeyframe>(*k);
    copy->id = both.idOf(*k);
    copy->segment = k->segment + segments;
    copy->T_W_B = *both.graph().poseOf(copy->id);
    pairs.push_back({copy->T_W_B.p, k->T_W_B.p, 1});
    if (known.has(*k)) {
      ++out.known;
      continue;
    }
    out.map.keyframes.push_back(std::move(copy));
  }
  // Anchors belong to no keyframe: they go with the path as a whole.
  const LevelFit fit = fitLevel(pairs);
  const MissionMap there = moved(second, fit.turn_known ? fit.T_A_B : both.graph().correction());
  std::map<std::uint64_t, Anchor> anchors;
  for (const Anchor& a : there.anchors) anchors[a.id] = a;
  for (const Anchor& a : first.anchors) anchors[a.id] = a;
  out.map.anchors.clear();
  for (const auto& [id, a] : anchors) out.map.anchors.push_back(a);
  return out;
}

}  // namespace vir::mission
