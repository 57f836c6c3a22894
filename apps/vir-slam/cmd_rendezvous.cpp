/// vir-slam rendezvous INI: robots that ranged to each other, in one world.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "commands.h"
#include "console.h"
#include "joint_merge.h"
#include "rendezvous_options.h"
#include "rendezvous_output.h"
#include "rendezvous_robots.h"
#include "vir/pipeline/rendezvous_registry.h"

namespace vir::app {
namespace {

constexpr const char* kHelp =
    R"(Find the transforms between the worlds of robots that ranged to each other
Examples:
  vir-slam rendezvous ini/two_robots.ini --rawlog A=a.rawlog --rawlog B=b.rawlog --out results/ab
  vir-slam rendezvous ini/two_robots.ini --rawlog spiri:3=one.rawlog --rawlog m:5=two.rawlog
NAME is followed by the robot's id as a beacon in the others' recordings; without it a single letter
stands for its place in the alphabet (A = 0), any other name for its place in the list.)";

struct Arguments {
  std::string ini, out;
  std::vector<std::string> rawlogs, assignments;
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

std::vector<TransformEdge> edgesOf(const std::vector<PairResult>& pairs) {
  std::vector<TransformEdge> edges;
  for (const PairResult& p : pairs) {
    const PairTransform& t = p.transform;
    if (t.answer.status != TransformStatus::unique) continue;
    edges.push_back({t.from, t.to, t.answer.solutions[0].T_A_B, t.answer.solutions[0].covariance});
  }
  return edges;
}

MergedMap merge(const std::vector<RobotRecord>& robots, const std::vector<TransformEdge>& edges) {
  MergedMap map;
  map.root = robots.front().name;
  map.T_root = commonFrame(map.root, edges);
  for (const RobotRecord& robot : robots) {
    const auto T = map.T_root.find(robot.name);
    if (T == map.T_root.end()) continue;
    Trajectory& out = map.trajectories[robot.name];
    for (const KnownPose& p : robot.poses) out.push_back({p.t, T->second.pose() * p.T_W_B});
  }
  return map;
}

const RobotRecord& named(const std::vector<RobotRecord>& robots, const std::string& name) {
  return *std::find_if(robots.begin(), robots.end(),
                       [&](const RobotRecord& r) { return r.name == name; });
}

std::vector<TableRow> rowsOf(const PairResult& pair, const std::optional<MergeError>& error) {
  const PairTransform& t = pair.transform;
  const TransformAnswer& a = t.answer;
  std::vector<TableRow> rows{{t.from + " in " + t.to, name(a.status), ""}};
  if (!a.reason.empty()) rows.push_back({"  why", a.reason, ""});
  rows.push_back({"  mutual ranges", std::to_string(pair.ranges.list.size()), ""});
  if (!a.solutions.empty()) {
    const TransformSolution& s = a.solutions[0];
    const Eigen::Vector4d sigma = s.covariance.diagonal().cwiseMax(0).cwiseSqrt();
    const auto& p = s.T_A_B.t_m;
    rows.push_back(
        {"  yaw", fixed(s.T_A_B.yaw_rad * 180 / M_PI, 2) + " +- " + fixed(sigma[0] * 180 / M_PI, 2),
         "deg"});
    rows.push_back(
        {"  offset", fixed(p.x(), 3) + " " + fixed(p.y(), 3) + " " + fixed(p.z(), 3), "m"});
    rows.push_back({"    standard deviation",
                    fixed(sigma[1], 3) + " " + fixed(sigma[2], 3) + " " + fixed(sigma[3], 3), "m"});
    rows.push_back({"  ranges used, rejected",
                    std::to_string(s.used) + ", " + std::to_string(s.rejected), ""});
    rows.push_back({"  common anchors used", std::to_string(s.anchors_used), ""});
  }
  rows.push_back(
      {"  first unique after", t.first_unique_s ? fixed(*t.first_unique_s, 1) : "-", "s"});
  if (error) {
    rows.push_back({"  merged trajectory, RMSE", fixed(error->merged_rmse_m, 3), "m"});
    rows.push_back(
        {"  error of the offset, yaw",
         fixed(error->offset_error_m, 3) + " m, " + fixed(error->yaw_error_deg, 2) + " deg", ""});
  }
  return rows;
}

nlohmann::ordered_json errorJson(const MergeError& e) {
  return {{"from", e.from},
          {"to", e.to},
          {"merged_rmse_m", e.merged_rmse_m},
          {"own_merged_rmse_m", e.own_merged_rmse_m},
          {"offset_error_m", e.offset_error_m},
          {"yaw_error_deg", e.yaw_error_deg}};
}

void run(const Arguments& arguments, Common& common) {
  const Prepared prepared =
      prepareRobots(arguments.ini, arguments.rawlogs, arguments.assignments, common);
  const ResultsFolder folder(arguments.out);
  writeTextFile(folder.file("used.ini"), prepared.used_ini);
  OutputFile log_file(folder.file("run.log"));
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
  std::vector<RobotRecord> robots;
  for (std::size_t i = 0; i < prepared.robots.size(); ++i) {
    const auto progress = [&](double part) {
      bar.show((static_cast<double>(i) + part) / static_cast<double>(prepared.robots.size()));
    };
    robots.push_back(runRobot(prepared, i, folder, log, progress));
  }
  bar.clear();

  std::vector<PairResult> pairs = findPairs(prepared, robots, log);
  const std::vector<TransformEdge> edges = edgesOf(pairs);
  const std::vector<TransformLoop> loops = checkLoops(edges);
  for (const TransformLoop& loop : loops) {
    if (!loop.consistent) {
      log(LogLevel::warning, "the transforms between " + loop.robots + " contradict each other");
    }
  }
  MergedMap map = merge(robots, edges);
  JointSolution joint;
  if (prepared.rendezvous.joint && !edges.empty()) {
    const std::string problem = mergeJointly(robots, prepared.joint, &map, &pairs, &joint);
    if (!problem.empty()) log(LogLevel::info, problem);
  }
  std::vector<PairTransform> transforms;
  nlohmann::ordered_json summary;
  summary["robots"] = nlohmann::ordered_json::array();
  for (const RobotRecord& r : robots) summary["robots"].push_back(r.name);
  summary["merge_errors"] = nlohmann::ordered_json::array();
  std::vector<TableRow> rows;
  for (const PairResult& pair : pairs) {
    transforms.push_back(pair.transform);
    std::optional<MergeError> error;
    const auto& a = pair.transform.answer;
    if (a.status == TransformStatus::unique) {
      error = mergeError(named(robots, pair.transform.to), named(robots, pair.transform.from),
                         a.solutions[0].T_A_B, map);
      if (error) summary["merge_errors"].push_back(errorJson(*error));
    }
    const auto more = rowsOf(pair, error);
    rows.insert(rows.end(), more.begin(), more.end());
  }
  writeTextFile(folder.file("transforms.json"), transformsJson(transforms, loops, map.root));
  writeTextFile(folder.file("summary.json"), summary.dump(2) + "\n");
  writeHistory(folder, pairs);
  writeMergedTrajectories(folder, map);
  writeMergedLandmarks(folder, map, robots);
  writeTextFile(folder.file("rendezvous.svg"), toSvg(rendezvousFigure(map, robots)));
  for (const RobotRecord& r : robots) {
    if (map.T_root.count(r.name) > 0) continue;
    log(LogLevel::error, "robot " + r.name + " cannot be placed in the world of " + map.root);
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
      ->add_option("--rawlog", arguments->rawlogs,
                   "NAME=FILE or NAME:ID=FILE, one per robot (instead of [Robots] in the ini)")
      ->allow_extra_args(false);
  command->add_option("--out", arguments->out, "Results folder (default: results/<date-time>)");
  command
      ->add_option("--set", arguments->assignments, "Section.key=value, before what the ini says")
      ->allow_extra_args(false);
  command->add_flag("--verbose,-v", arguments->verbose, "Show the whole log, not only warnings");
  command->callback([arguments, &common] { run(*arguments, common); });
}

}  // namespace vir::app
