#include "robots/joint_merge.h"

#include <algorithm>

namespace vir::app {
namespace {

/// Where there are images, odometry poses were not what the robot was estimated from.
bool byOdometry(const RobotRecord& record) { return !record.sees && record.odometry.size() >= 2; }

struct Member {
  const RobotRecord* record;
  std::size_t place;  // in the joint problem
};

team::JointRobot jointRobotOf(const RobotRecord& record, const team::WorldTransform& T_root) {
  team::JointRobot robot;
  robot.T_C_W = T_root;
  for (const StampedPose& p : record.odometry) {
    if (!robot.odometry.empty() && p.t <= robot.odometry.back().t) continue;
    robot.odometry.push_back({p.t, p.T_W_B});
  }
  for (const KnownPose& p : record.poses) robot.estimate.push_back({p.t, p.T_W_B});
  for (const AnchorRangeObservation& r : record.anchor_ranges) {
    robot.anchor_ranges.push_back({r.t, r.anchor, r.range_m, r.sigma_m, r.p_B_U});
  }
  return robot;
}

const Member* find(const std::vector<Member>& members, const std::string& name) {
  const auto it = std::find_if(members.begin(), members.end(),
                               [&](const Member& m) { return m.record->name == name; });
  return it == members.end() ? nullptr : &*it;
}

Vec3 leverOf(const RobotRecord& robot) {
  return robot.peer_ranges.empty() ? Vec3(Vec3::Zero()) : robot.peer_ranges.front().p_B_U;
}

std::vector<team::JointMutualRange> mutualOf(const std::vector<PairResult>& pairs,
                                             const std::vector<Member>& members) {
  std::vector<team::JointMutualRange> out;
  for (const PairResult& pair : pairs) {
    const Member* a = find(members, pair.transform.to);
    const Member* b = find(members, pair.transform.from);
    if (a == nullptr || b == nullptr) continue;
    for (const MutualObservation& m : pair.ranges.list) {
      out.push_back({m.range.t, a->place, b->place, m.range.range_m, m.range.sigma_m,
                     leverOf(*a->record), leverOf(*b->record)});
    }
  }
  return out;
}

void takeOver(const team::JointSolution& solution, const std::vector<Member>& members,
              MergedMap* map, std::vector<PairResult>* pairs) {
  // The root's own world is the common frame of the files, not that of the problem.
  const team::WorldTransform T_root_C = solution.T_C_W[0].inverse();
  for (const Member& m : members) {
    map->T_root[m.record->name] = T_root_C * solution.T_C_W[m.place];
    Trajectory& out = map->trajectories[m.record->name];
    out.clear();
    for (const StampedPose& p : solution.trajectories[m.place]) {
      out.push_back({p.t, T_root_C.pose() * p.T_W_B});
    }
  }
  for (PairResult& pair : *pairs) {
    const Member* a = find(members, pair.transform.to);
    const Member* b = find(members, pair.transform.from);
    if (a == nullptr || b == nullptr || pair.transform.answer.solutions.empty()) continue;
    if (pair.transform.answer.status != team::TransformStatus::unique) continue;
    team::TransformSolution& s = pair.transform.answer.solutions[0];
    s.T_A_B = solution.between(a->place, b->place);
    s.T_A_B.yaw_rad = team::wrapAngle(s.T_A_B.yaw_rad);
    const double height = s.covariance(3, 3);
    s.covariance = solution.covarianceBetween(a->place, b->place);
    // Level robots kept the height that was found before.
    if (solution.heights_held) s.covariance(3, 3) += height;
    pair.transform.joint = true;
  }
}

}  // namespace

std::string mergeJointly(const std::vector<RobotRecord>& robots, const team::JointOptions& options,
                         MergedMap* map, std::vector<PairResult>* pairs,
                         team::JointSolution* solution) {
  std::vector<team::JointRobot> problem;
  std::vector<Member> members;
  // The first one's world is that of the problem.
  std::vector<const RobotRecord*> ordered;
  for (const RobotRecord& record : robots) {
    ordered.insert(record.name == map->root ? ordered.begin() : ordered.end(), &record);
  }
  for (const RobotRecord* one : ordered) {
    const RobotRecord& record = *one;
    const auto T = map->T_root.find(record.name);
    if (T == map->T_root.end() || record.poses.size() < 2) continue;
    if (!byOdometry(record)) {
      return "no joint solution: robot " + record.name +
             " was not estimated from odometry poses; its path holds the anchors' ranges already";
    }
    const bool restarted = std::any_of(record.poses.begin(), record.poses.end(),
                                       [](const KnownPose& p) { return p.segment > 0; });
    if (restarted) return "robot " + record.name + " started a new world: no joint solution";
    members.push_back({&record, problem.size()});
    problem.push_back(jointRobotOf(record, T->second));
  }
  if (problem.size() < 2 || members[0].record->name != map->root) {
    return "no joint solution: it needs two robots with poses that are tied together";
  }
  *solution = team::solveJointly(problem, mutualOf(*pairs, members), options);
  if (!solution->solved) return "no joint solution: " + solution->problem;
  takeOver(*solution, members, map, pairs);
  return "";
}

}  // namespace vir::app
