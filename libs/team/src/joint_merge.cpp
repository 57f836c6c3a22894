#include "vir/team/joint_merge.h"

#include <algorithm>
#include <cmath>

namespace vir::team {
namespace {

/// Where there are images, odometry poses were not what the robot was estimated from.
bool byOdometry(const RobotRecord& record) { return !record.sees && record.odometry.size() >= 2; }

struct Member {
  const RobotRecord* record;
  std::size_t place;  // in the joint problem
};

JointRobot jointRobotOf(const RobotRecord& record, const WorldTransform& T_root) {
  JointRobot robot;
  robot.T_C_W = T_root;
  for (const StampedPose& p : record.odometry) {
    if (!robot.odometry.empty() && p.t <= robot.odometry.back().t) continue;
    robot.odometry.push_back({p.t, p.T_W_B});
  }
  for (const KnownPose& p : record.poses) robot.estimate.push_back({p.t, p.T_W_B});
  robot.anchor_ranges = record.anchor_ranges;
  return robot;
}

const Member* find(const std::vector<Member>& members, const std::string& name) {
  const auto it = std::find_if(members.begin(), members.end(),
                               [&](const Member& m) { return m.record->name == name; });
  return it == members.end() ? nullptr : &*it;
}

std::vector<JointMutualRange> mutualOf(const std::vector<PairResult>& pairs,
                                       const std::vector<Member>& members) {
  std::vector<JointMutualRange> out;
  for (const PairResult& pair : pairs) {
    const Member* a = find(members, pair.transform.to);
    const Member* b = find(members, pair.transform.from);
    if (a == nullptr || b == nullptr) continue;
    for (const MutualObservation& m : pair.ranges.list) {
      // The joint problem has no doubt about antennas: the range bears it.
      const double sigma_m =
          m.antenna_unknown ? std::hypot(m.range.sigma_m, kUnknownAntennaSigma) : m.range.sigma_m;
      out.push_back(
          {m.range.t, a->place, b->place, m.range.range_m, sigma_m, m.antenna_A, m.antenna_B});
    }
  }
  return out;
}

void takeOver(const JointSolution& solution, const std::vector<Member>& members, MergedMap* map,
              std::vector<PairResult>* pairs) {
  // The root's own world is the common frame of the files, not that of the problem.
  const WorldTransform T_root_C = solution.T_C_W[0].inverse();
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
    if (pair.transform.answer.status != TransformStatus::unique) continue;
    TransformSolution& s = pair.transform.answer.solutions[0];
    s.T_A_B = solution.between(a->place, b->place);
    s.T_A_B.yaw_rad = wrapAngle(s.T_A_B.yaw_rad);
    const double height = s.covariance(3, 3);
    s.covariance = solution.covarianceBetween(a->place, b->place);
    // Level robots kept the height that was found before.
    if (solution.heights_held) s.covariance(3, 3) += height;
    pair.transform.joint = true;
  }
}

}  // namespace

std::string mergeJointly(const std::vector<RobotRecord>& robots, const JointOptions& options,
                         MergedMap* map, std::vector<PairResult>* pairs, JointSolution* solution) {
  std::vector<JointRobot> problem;
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
  *solution = solveJointly(problem, mutualOf(*pairs, members), options);
  if (!solution->solved) return "no joint solution: " + solution->problem;
  takeOver(*solution, members, map, pairs);
  return "";
}

}  // namespace vir::team
