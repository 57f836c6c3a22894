/// vir-slam rendezvous INI: robots that ranged to each other, in one world.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "commands/commands.h"
#include "output/console.h"
#include "output/rendezvous_report.h"
#include "robots/joint_merge.h"
#include "robots/rendezvous_options.h"
#include "robots/rendezvous_robots.h"
#include "vir/roles/rendezvous_registry.h"

namespace vir::app {
namespace {

constexpr const char* kHelp =
    R"(Find the transforms between the worlds of robots that ranged to each other
Examples:
  vir-slam rendezvous ini/two_robots.ini --rawlog A=a.rawlog --rawlog B=b.rawlog --out results/ab
  vir-slam rendezvous ini/two_robots.ini --rawlog spiri:3=one.rawlog --rawlog m:5=two.rawlog
  vir-slam rendezvous ini/two_robots.ini --rawlog A=results/a --rawlog B=results/b
NAME is followed by the robot's id as a beacon in the others' recordings; without it a single letter
stands for its place in the alphabet (A = 0), any other name for its place in the list. In place of a
recording the results folder of a finished `vir-slam run` can be given: it is not estimated again.)";

struct Arguments : RobotArguments {
  std::string out;
  bool verbose = false;
};

using Log = LogSink;

std::vector<PairResult> findPairs(const Prepared& prepared, const std::vector<RobotRecord>& robots,
                                  const Log& log) {
  std::vector<PairResult> pairs;
  for (std::size_t i = 0; i < robots.size(); ++i) {
    for (std::size_t j = i + 1; j < robots.size(); ++j) {
      const auto solver = prepared.createSolver(log);
      pairs.push_back(playPair(robots[i], robots[j], solver.get(), prepared.rendezvous.interval_s,
                               prepared.rendezvous.use_anchors));
      const MutualRanges& ranges = pairs.back().ranges;
      if (ranges.without_state == 0) continue;
      vir::log(log, LogLevel::warning,
               std::to_string(ranges.without_state) + " ranges between " + robots[i].name +
                   " and " + robots[j].name + " came when one of them had no pose: not used");
    }
  }
  return pairs;
}

std::vector<team::TransformEdge> edgesOf(const std::vector<PairResult>& pairs) {
  std::vector<team::TransformEdge> edges;
  for (const PairResult& p : pairs) {
    const team::PairTransform& t = p.transform;
    if (t.answer.status != team::TransformStatus::unique) continue;
    edges.push_back({t.from, t.to, t.answer.solutions[0].T_A_B, t.answer.solutions[0].covariance});
  }
  return edges;
}

/// In the world of the robot that most others can be tied to; of equals, the first one given.
MergedMap merge(const std::vector<RobotRecord>& robots,
                const std::vector<team::TransformEdge>& edges) {
  MergedMap map;
  for (const RobotRecord& robot : robots) {
    auto tied = team::commonFrame(robot.name, edges);
    if (!map.root.empty() && tied.size() <= map.T_root.size()) continue;
    map.root = robot.name;
    map.T_root = std::move(tied);
  }
  for (const RobotRecord& robot : robots) {
    const auto T = map.T_root.find(robot.name);
    if (T == map.T_root.end()) continue;
    Trajectory& out = map.trajectories[robot.name];
    for (const KnownPose& p : robot.poses) out.push_back({p.t, T->second.pose() * p.T_W_B});
  }
  return map;
}

std::vector<RobotRecord> runAll(const Prepared& prepared, const results::ResultsFolder& folder,
                                const Log& log, ProgressBar* bar) {
  std::vector<RobotRecord> robots;
  const auto n = static_cast<double>(prepared.robots.size());
  for (std::size_t i = 0; i < prepared.robots.size(); ++i) {
    const auto progress = [&](double part) { bar->show((static_cast<double>(i) + part) / n); };
    robots.push_back(runRobot(prepared, i, folder, log, progress));
  }
  bar->clear();
  return robots;
}

/// Ties the robots together.
Meeting meet(const Prepared& prepared, std::vector<RobotRecord> robots, const Log& log) {
  Meeting out;
  out.robots = std::move(robots);
  out.pairs = findPairs(prepared, out.robots, log);
  const std::vector<team::TransformEdge> edges = edgesOf(out.pairs);
  out.loops = team::checkLoops(edges);
  for (const team::TransformLoop& loop : out.loops) {
    if (!loop.consistent) {
      log(LogLevel::warning, "the transforms between " + loop.robots + " contradict each other");
    }
  }
  out.map = merge(out.robots, edges);
  if (prepared.rendezvous.joint && !edges.empty()) {
    team::JointSolution joint;
    const std::string problem =
        mergeJointly(out.robots, prepared.joint, &out.map, &out.pairs, &joint);
    if (!problem.empty()) log(LogLevel::info, problem);
  }
  return out;
}

void run(const Arguments& arguments, Common& common) {
  const Prepared prepared = prepareRobots(arguments, common);
  const results::ResultsFolder folder(arguments.out);
  results::writeTextFile(folder.file("used.ini"), prepared.used_ini);
  results::OutputFile log_file(folder.file("run.log"));
  ProgressBar bar;
  const Log log = [&](LogLevel level, const std::string& text) {
    static const char* const kLevels[] = {"debug", "info", "warning", "error"};
    const char* const word = kLevels[static_cast<int>(level)];
    log_file.line(std::string(word) + ": " + text);
    if (level != LogLevel::warning && level != LogLevel::error && !arguments.verbose) return;
    bar.clear();
    std::fprintf(stderr, "%s: %s\n", word, text.c_str());
  };
  catchInterrupt();
  const Meeting meeting = meet(prepared, runAll(prepared, folder, log, &bar), log);
  const std::vector<TableRow> rows = writeMeeting(folder, meeting);
  for (const RobotRecord& r : meeting.robots) {
    if (meeting.map.T_root.count(r.name) > 0) continue;
    log(LogLevel::error,
        "robot " + r.name + " cannot be placed in the world of " + meeting.map.root);
    common.exit_code = kRunFailed;
  }
  log_file.close();
  printTable(rows);
  std::printf("Results in %s\n", folder.path().c_str());
}

}  // namespace

void addRendezvous(CLI::App& app, Common& common) {
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("rendezvous", kHelp);
  command->add_option("INI", arguments->ini, "Settings, e.g. ini/two_robots.ini")->required();
  command
      ->add_option(
          "--rawlog", arguments->rawlogs,
          "NAME=FILE or NAME:ID=FILE, one per robot (instead of [Robots] in the ini); FILE: a "
          "recording, or the results folder of a finished run")
      ->allow_extra_args(false);
  command
      ->add_option("--ranges", arguments->ranges,
                   "NAME=FILE: the recording a finished run was made from, where the run's "
                   "summary.json does not lead to it")
      ->allow_extra_args(false);
  command->add_option("--out", arguments->out, "Results folder (default: results/<date-time>)");
  command
      ->add_option("--set", arguments->assignments, "Section.key=value, before what the ini says")
      ->allow_extra_args(false);
  command->add_flag("--verbose,-v", arguments->verbose, "Show the whole log, not only warnings");
  command->callback([arguments, &common] { run(*arguments, common); });
}

}  // namespace vir::app
