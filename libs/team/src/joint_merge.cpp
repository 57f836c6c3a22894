#include "vir/team/joint_merge.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace vir::team {
namespace {

/// A height whose sigma is larger [m] is tried out, in steps of it that are halved so often.
constexpr double kOpenHeight = 0.1, kLargestStep = 2;
constexpr int kHeightRounds = 5;

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

using Worlds = std::map<std::string, WorldTransform>;

/// Level robots keep the heights they begin with, which must be such as explain the ranges: not the
/// mean of two.
Worlds atLikelierHeights(const MergedMap& map, const std::vector<PairResult>& pairs) {
  std::vector<TransformEdge> edges = edgesOf(pairs);
  bool other = false;
  for (TransformEdge& e : edges) {
    for (const PairResult& p : pairs) {
      if (p.transform.from != e.from || p.transform.to != e.to) continue;
      const auto& z = p.transform.answer.solutions[0].likelier_z_m;
      if (z) e.T_to_from.t_m.z() = *z;
      other = other || z;
    }
  }
  return other ? commonFrame(map.root, edges) : map.T_root;
}

/// Of the height of a robot against the root [m]; 0 where no pair says it.
double heightSigma(const std::string& robot, const std::string& root,
                   const std::vector<PairResult>& pairs) {
  for (const PairResult& p : pairs) {
    const bool theirs = (p.transform.from == robot && p.transform.to == root) ||
                        (p.transform.from == root && p.transform.to == robot);
    if (!theirs || p.transform.answer.solutions.empty()) continue;
    return std::sqrt(std::max(0.0, p.transform.answer.solutions[0].covariance(3, 3)));
  }
  return 0;
}

/// Level robots keep the heights they begin with, since ranges know these by their squares only.
/// Which of them explains all ranges best is tried out, from where `robots` begin.
JointSolution solveAtBestHeights(std::vector<JointRobot> robots,
                                 const std::vector<JointMutualRange>& mutual,
                                 const std::vector<double>& sigmas, const JointOptions& options,
                                 std::vector<double>* raised) {
  JointSolution best = solveJointly(robots, mutual, options);
  raised->assign(robots.size(), 0);
  if (!best.solved || !best.heights_held) return best;
  for (std::size_t i = 1; i < robots.size(); ++i) {
    if (sigmas[i] < kOpenHeight) continue;
    double step = std::min(sigmas[i], kLargestStep);
    for (int round = 0; round < kHeightRounds; ++round, step *= 0.5) {
      for (const double side : {step, -step}) {
        std::vector<JointRobot> tried = robots;
        tried[i].T_C_W.t_m.z() += side;
        JointSolution solution = solveJointly(tried, mutual, options);
        if (!solution.solved || !(solution.cost < best.cost)) continue;
        best = std::move(solution);
        robots = std::move(tried);
        (*raised)[i] += side;
        break;
      }
    }
  }
  return best;
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

/// `start`: where the problem began; heights are told as they were in `map`.
void takeOver(const JointSolution& solution, const std::vector<Member>& members,
              const Worlds& start, MergedMap* map, std::vector<PairResult>* pairs) {
  // The root's own world is the common frame of the files, not that of the problem.
  const WorldTransform T_root_C = solution.T_C_W[0].inverse();
  for (const Member& m : members) {
    WorldTransform& T_root = map->T_root[m.record->name];
    const Vec3 raised(0, 0, T_root.t_m.z() - start.at(m.record->name).t_m.z());
    T_root = T_root_C * solution.T_C_W[m.place];
    T_root.t_m += raised;
    Eigen::Matrix4d& C = map->covariance[m.record->name];
    const double height = C(3, 3);
    C = solution.covarianceBetween(0, m.place);
    if (solution.heights_held && m.place != 0) C(3, 3) += height;
    Trajectory& out = map->trajectories[m.record->name];
    out.clear();
    for (const StampedPose& p : solution.trajectories[m.place]) {
      out.push_back({p.t, T_root_C.pose() * p.T_W_B});
      out.back().T_W_B.p += raised;
    }
  }
  for (PairResult& pair : *pairs) {
    const Member* a = find(members, pair.transform.to);
    const Member* b = find(members, pair.transform.from);
    if (a == nullptr || b == nullptr || pair.transform.answer.solutions.empty()) continue;
    if (pair.transform.answer.status != TransformStatus::unique) continue;
    TransformSolution& s = pair.transform.answer.solutions[0];
    const double z = s.T_A_B.t_m.z();
    s.T_A_B = solution.between(a->place, b->place);
    s.T_A_B.yaw_rad = wrapAngle(s.T_A_B.yaw_rad);
    // What the ranges are explained by is one of two heights; what is known is their mean.
    if (solution.heights_held || s.likelier_z_m) s.T_A_B.t_m.z() = z;
    const double height = s.covariance(3, 3);
    s.covariance = solution.covarianceBetween(a->place, b->place);
    // Level robots kept the height that was found before.
    if (solution.heights_held || s.likelier_z_m) s.covariance(3, 3) += height;
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
  Worlds start = atLikelierHeights(*map, *pairs);
  for (const RobotRecord* one : ordered) {
    const RobotRecord& record = *one;
    const auto T = start.find(record.name);
    if (T == start.end() || record.poses.size() < 2) continue;
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
  std::vector<double> sigmas, raised;
  for (const Member& m : members) {
    sigmas.push_back(heightSigma(m.record->name, map->root, *pairs));
  }
  *solution = solveAtBestHeights(problem, mutualOf(*pairs, members), sigmas, options, &raised);
  if (!solution->solved) return "no joint solution: " + solution->problem;
  for (const Member& m : members) start[m.record->name].t_m.z() += raised[m.place];
  takeOver(*solution, members, start, map, pairs);
  return "";
}

}  // namespace vir::team
