#include "vir/team/meeting.h"

#include <cstdio>

#include "vir/team/joint_merge.h"

namespace vir::team {
namespace {

/// What the user should know about a pair's ranges.
void tellOfRanges(const MutualRanges& ranges, const RobotRecord& a, const RobotRecord& b,
                  const LogSink& log) {
  if (ranges.without_state > 0) {
    vir::log(log, LogLevel::warning,
             std::to_string(ranges.without_state) + " ranges between " + a.name + " and " + b.name +
                 " came when one of them had no pose: not used");
  }
  if (ranges.doubled > 0) {
    vir::log(log, LogLevel::info,
             std::to_string(ranges.doubled) + " ranges between " + a.name + " and " + b.name +
                 " are in both recordings: each is used once");
  }
  if (ranges.antenna_unknown > 0) {
    const std::string& silent = a.antenna() ? b.name : a.name;
    char sigma[16];
    std::snprintf(sigma, sizeof sigma, "%.1f", kUnknownAntennaSigma);
    vir::log(log, LogLevel::warning,
             "the recording of robot " + silent +
                 " has no range in it, so nobody knows where its antenna is: taken at its body's "
                 "origin, +- " +
                 sigma + " m");
  }
}

void tellOfPlaces(const PairResult& pair, const LogSink& log) {
  const TransformAnswer& answer = pair.transform.answer;
  if (answer.places == 0 || answer.solutions.empty()) return;
  if (answer.solutions.front().places_used > 0) return;
  vir::log(log, LogLevel::warning,
           std::to_string(answer.places) + " places that " + pair.transform.to + " and " +
               pair.transform.from +
               " seem to have seen both contradict the ranges: not used, they may only look alike");
}

std::vector<PairResult> findPairs(const std::vector<RobotRecord>& robots,
                                  const MeetingOptions& options,
                                  const PairSolverFactory& create_solver, const LogSink& log,
                                  const PlacesOfPairs& places) {
  std::vector<PairResult> pairs;
  for (std::size_t i = 0; i < robots.size(); ++i) {
    for (std::size_t j = i + 1; j < robots.size(); ++j) {
      const auto solver = create_solver(log);
      const auto seen = places.find({robots[i].name, robots[j].name});
      pairs.push_back(playPair(
          robots[i], robots[j], solver.get(), {options.interval_s, options.use_anchors},
          seen == places.end() ? std::nullopt : std::optional<SharedPlaces>(seen->second)));
      tellOfPlaces(pairs.back(), log);
      tellOfRanges(pairs.back().ranges, robots[i], robots[j], log);
    }
  }
  return pairs;
}

}  // namespace

Meeting meet(std::vector<RobotRecord> robots, const MeetingOptions& options,
             const PairSolverFactory& create_solver, const LogSink& log,
             const PlacesOfPairs& places) {
  Meeting out;
  out.robots = std::move(robots);
  out.pairs = findPairs(out.robots, options, create_solver, log, places);
  const std::vector<TransformEdge> edges = edgesOf(out.pairs);
  out.map = merge(out.robots, edges);
  for (const TransformLoop& loop : out.map.loops) {
    if (loop.consistent) continue;
    vir::log(log, LogLevel::warning,
             "the transforms between " + loop.robots + " contradict each other");
  }
  for (const TransformEdge& e : out.map.left_out) {
    vir::log(log, LogLevel::warning,
             "the transform between " + e.to + " and " + e.from +
                 " contradicts the others: left out of the common frame");
  }
  if (options.solve_jointly && !edges.empty()) {
    JointSolution joint;
    const std::string problem =
        mergeJointly(out.robots, options.joint, &out.map, &out.pairs, &joint);
    if (!problem.empty()) vir::log(log, LogLevel::info, problem);
  }
  return out;
}

}  // namespace vir::team
