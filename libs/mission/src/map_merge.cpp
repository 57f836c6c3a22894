#include "vir/mission/map_merge.h"

#include <algorithm>
#include <map>
#include <stdexcept>

#include "place_graph.h"

namespace vir::mission {
namespace {

/// Between keyframes whose stamps do not rise: of another run than the one before.
constexpr TimeNs kApart = 1000000000;

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
  const std::string other = cameraDifference(first.calibration.camera, second.calibration.camera);
  if (!other.empty()) throw std::runtime_error("the maps are of different cameras: " + other);
  if (first.keyframes.empty() || second.keyframes.empty()) {
    throw std::runtime_error("a map without keyframes has no place that could be found");
  }
  const Known known(first);
  if (std::all_of(second.keyframes.begin(), second.keyframes.end(),
                  [&](const auto& k) { return known.has(*k); })) {
    return {first, {}, static_cast<long>(second.keyframes.size())};
  }
  PlaceGraph places(options);
  int segments = 0;
  for (const auto& k : first.keyframes) {
    places.remember(*k);
    segments = std::max(segments, k->segment + 1);
  }
  const std::uint64_t last = first.keyframes.back()->id;
  TimeNs t = 0;
  for (const auto& k : second.keyframes) {
    auto copy = std::make_shared<PlaceKeyframe>(*k);
    copy->id = last + 1 + (k->id - second.keyframes.front()->id);
    const bool rises = k == second.keyframes.front() || k->t > t;
    t = copy->t = rises ? k->t : t + kApart;
    PathNode node;
    node.id = copy->id;
    node.t = node.segment_since = t;
    node.segment = copy->segment;
    node.T_W_B = copy->T_W_B;
    places.add(std::move(copy), node);
    if (places.graph().solveDue()) places.graph().solve();
  }
  places.graph().solve();
  if (!places.graph().joined()) {
    throw std::runtime_error("no place of the one map was found in the other");
  }

  MergedMaps out{first, places.graph().counts(), 0};
  std::vector<LevelPair> pairs;
  for (const auto& k : second.keyframes) {
    auto copy = std::make_shared<PlaceKeyframe>(*k);
    copy->id = last + 1 + (k->id - second.keyframes.front()->id);
    copy->segment = k->segment + segments;
    copy->T_W_B = *places.graph().poseOf(copy->id);
    pairs.push_back({copy->T_W_B.p, k->T_W_B.p, 1});
    if (known.has(*k)) {
      ++out.known;
      continue;
    }
    out.map.keyframes.push_back(std::move(copy));
  }
  // Anchors belong to no keyframe: they go with the path as a whole.
  const LevelFit fit = fitLevel(pairs);
  const MissionMap there = moved(second, fit.turn_known ? fit.T_A_B : places.graph().correction());
  std::map<std::uint64_t, Anchor> anchors;
  for (const Anchor& a : there.anchors) anchors[a.id] = a;
  for (const Anchor& a : first.anchors) anchors[a.id] = a;
  out.map.anchors.clear();
  for (const auto& [id, a] : anchors) out.map.anchors.push_back(a);
  return out;
}

}  // namespace vir::mission
