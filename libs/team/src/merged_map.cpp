#include "vir/team/merged_map.h"

namespace vir::team {

std::vector<TransformEdge> edgesOf(const std::vector<PairResult>& pairs) {
  std::vector<TransformEdge> edges;
  for (const PairResult& p : pairs) {
    const PairTransform& t = p.transform;
    if (t.answer.status != TransformStatus::unique) continue;
    edges.push_back({t.from, t.to, t.answer.solutions[0].T_A_B, t.answer.solutions[0].covariance});
  }
  return edges;
}

MergedMap mapOf(const TeamGraph& graph) {
  MergedMap map;
  map.root = graph.root;
  for (const auto& [name, world] : graph.worlds) {
    map.T_root[name] = world.T_root;
    map.covariance[name] = world.covariance;
  }
  map.left_out = graph.left_out;
  map.loops = graph.loops;
  return map;
}

MergedMap merge(const std::vector<RobotRecord>& robots, const std::vector<TransformEdge>& edges) {
  MergedMap map;
  for (const RobotRecord& robot : robots) {
    const TeamGraph tied = solveTeam(robot.name, edges);
    if (!map.root.empty() && tied.worlds.size() <= map.T_root.size()) continue;
    map = mapOf(tied);
  }
  for (const RobotRecord& robot : robots) {
    const auto T = map.T_root.find(robot.name);
    if (T == map.T_root.end()) continue;
    Trajectory& out = map.trajectories[robot.name];
    for (const KnownPose& p : robot.poses) out.push_back({p.t, T->second.pose() * p.T_W_B});
  }
  return map;
}

}  // namespace vir::team
