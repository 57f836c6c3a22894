#pragma once
/// Internal: keyframes to the index of places and to the graph, and what the one says to the other.
#include <memory>
#include <optional>
#include <vector>

#include "vir/mission/loop_closer.h"

namespace vir::mission {

class PlaceGraph {
 public:
  explicit PlaceGraph(const LoopOptions& options)
      : finder_(options.finder, options.index, options.verify), graph_(options.graph) {}

  /// One of a map: it stays where it is. Segments are told apart from those of the run.
  void remember(const PlaceKeyframe& keyframe);
  /// The next one of a run; without `look` its place is only remembered. How many loops were
  /// accepted by it. Throws what MissionGraph::add() throws.
  long add(std::shared_ptr<const PlaceKeyframe> keyframe, const PathNode& node, bool look = true);
  /// Of the last add().
  std::vector<places::LoopAttempt> attempts() const;

  MissionGraph& graph() { return graph_; }
  const MissionGraph& graph() const { return graph_; }
  const places::LoopFinder& finder() const { return finder_; }

 private:
  places::LoopFinder finder_;
  MissionGraph graph_;
  bool looked_ = false;
};

}  // namespace vir::mission
