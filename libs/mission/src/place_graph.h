#pragma once
/// Internal: keyframes to the index of places and to the graph, and what the one says to the other.
#include <memory>
#include <optional>
#include <vector>

#include "level_algebra.h"
#include "vir/mission/loop_closer.h"
#include "vir/types/anchor.h"

namespace vir::mission {

class PlaceGraph {
 public:
  explicit PlaceGraph(const LoopOptions& options)
      : finder_(options.finder, options.index, options.verify), graph_(options.graph) {}

  /// One of a map: it stays where it is. Segments are told apart from those of the run.
  void remember(const PlaceKeyframe& keyframe);
  /// That of a remembered one, as the map had it.
  static int segmentInMap(const PlaceKeyframe& remembered) { return -1 - remembered.segment; }
  /// The next one of a run; without `look` its place is only remembered. How many loops were
  /// accepted by it. `compare`: see LoopFinder. Throws what MissionGraph::add() throws.
  long add(std::shared_ptr<const PlaceKeyframe> keyframe, const PathNode& node, bool look = true,
           const places::LoopFinder::Compare& compare = {});
  /// Second visits of the run's own places are of no interest, until told otherwise.
  void lookInMapOnly(bool only) { map_only_ = only; }
  /// What is known of anchors in the map and in the run, as long as nothing ties the two.
  void setAnchors(const std::vector<Anchor>& in_M, const std::vector<Anchor>& in_W);
  /// Loops of the last add() that the anchors contradict.
  const std::vector<Loop>& againstAnchors() const { return against_anchors_; }
  /// Of the last add().
  std::vector<places::LoopAttempt> attempts() const;

  MissionGraph& graph() { return graph_; }
  const MissionGraph& graph() const { return graph_; }
  const places::LoopFinder& finder() const { return finder_; }

 private:
  std::optional<places::RelativePrior> priorOf(const PlaceKeyframe& older,
                                               const PlaceKeyframe& newer) const;
  /// Can the place be in sight, as the anchors have it?
  bool inReach(const PlaceKeyframe& older, const PlaceKeyframe& newer) const;
  bool anchorsAllow(const Loop& loop, const PlaceKeyframe& newer) const;

  std::vector<Anchor> anchors_M_, anchors_W_;
  std::optional<LevelGuess> T_M_W_;  ///< by anchors; none once loops say it
  std::vector<Loop> against_anchors_;
  places::LoopFinder finder_;
  MissionGraph graph_;
  bool looked_ = false, map_only_ = false;
};

}  // namespace vir::mission
