/// vir-slam rendezvous INI: robots that ranged to each other, in one world.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <utility>

#include "commands/commands.h"
#include "output/console.h"
#include "output/overwrite.h"
#include "output/rendezvous_report.h"
#include "robots/common_places.h"
#include "robots/rendezvous_robots.h"
#include "vir/team/meeting.h"

namespace vir::app {
namespace {

constexpr const char* kHelp =
    R"(Find the transforms between the worlds of robots that ranged to each other, or saw the same places
Examples:
  vir-slam rendezvous --rawlog A=a.rawlog --rawlog B=b.rawlog --out results/ab
  vir-slam rendezvous ini/two_robots.ini --rawlog spiri:3=one.rawlog --rawlog m:5=two.rawlog
  vir-slam rendezvous ini/two_robots.ini --rawlog A=results/a --rawlog B=results/b
NAME is followed by the robot's id as a beacon in the others' recordings; without it a single letter
stands for its place in the alphabet (A = 0), any other name for its place in the list. In place of a
recording the results folder of a finished `vir-slam run` can be given: it is not estimated again. Places
that both have seen count where the run saved its map (--save-map).)";

struct Arguments : RobotArguments {
  std::string out;
  bool verbose = false;
};

using Log = LogSink;

std::vector<team::RobotRecord> runAll(const Prepared& prepared,
                                      const results::ResultsFolder& folder, const Log& log,
                                      ProgressBar* bar) {
  std::vector<team::RobotRecord> robots;
  const auto n = static_cast<double>(prepared.robots.size());
  for (std::size_t i = 0; i < prepared.robots.size(); ++i) {
    const auto progress = [&](double part) { bar->show((static_cast<double>(i) + part) / n); };
    robots.push_back(runRobot(prepared, i, folder, log, progress));
  }
  bar->clear();
  return robots;
}

team::MeetingOptions meetingOptions(const Prepared& prepared) {
  team::MeetingOptions options;
  options.interval_s = prepared.rendezvous.interval_s;
  options.use_anchors = prepared.rendezvous.use_anchors;
  options.solve_jointly = prepared.rendezvous.joint;
  options.joint = prepared.joint;
  return options;
}

void run(const Arguments& arguments, Common& common) {
  const Prepared prepared = prepareRobots(arguments, common);
  refuseToOverwrite(arguments.out, Written::results, common);
  for (const RobotFile& robot : prepared.robots) {
    if (!arguments.out.empty())
      refuseToOverwrite(arguments.out + "/" + robot.name, Written::results, common);
  }
  const results::ResultsFolder folder(arguments.out);
  results::writeTextFile(folder.file("used.ini"), prepared.used_ini);
  results::OutputFile log_file(folder.file("run.log"), results::OutputFile::Named::at_once);
  ProgressBar bar;
  MeetingOrigin origin{common.command, {}, {}};
  const Log log = [&](LogLevel level, const std::string& text) {
    log_file.line(std::string(levelName(level)) + ": " + text);
    if (level == LogLevel::warning) origin.warnings.push_back(text);
    if (level == LogLevel::error) origin.errors.push_back(text);
    if (level != LogLevel::warning && level != LogLevel::error && !arguments.verbose) return;
    bar.clear();
    std::fprintf(stderr, "%s: %s\n", levelName(level), text.c_str());
  };
  for (const std::string& line : prepared.calibration.said()) log(LogLevel::info, line);
  const auto create_solver = [&](const Log& sink) { return prepared.createSolver(sink); };
  std::vector<team::RobotRecord> robots = runAll(prepared, folder, log, &bar);
  const team::PlacesOfPairs places = placesInCommon(prepared, folder, robots, log);
  const team::Meeting meeting =
      team::meet(std::move(robots), meetingOptions(prepared), create_solver, log, places);
  if (interrupted()) common.exit_code = kRunFailed;
  for (const team::RobotRecord& r : meeting.robots) {
    if (r.damaged) {
      log(LogLevel::warning, "robot " + r.name + ": its recording is damaged or was cut off");
      common.exit_code = kRunFailed;
    }
    if (meeting.map.T_root.count(r.name) > 0) continue;
    log(LogLevel::error,
        "robot " + r.name + " cannot be placed in the world of " + meeting.map.root);
    common.exit_code = kRunFailed;
  }
  const std::vector<TableRow> rows = writeMeeting(folder, meeting, origin);
  log_file.close();
  printTable(rows);
  std::printf("Results in %s\n", folder.path().c_str());
}

}  // namespace

void addRendezvous(CLI::App& app, Common& common) {
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("rendezvous", kHelp);
  command->add_option("INI", arguments->ini,
                      "Settings, e.g. ini/two_robots.ini (without: all by default)");
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
  command
      ->add_option("--map", arguments->maps,
                   "NAME=FILE: the map of a finished run, where it was not saved into its folder")
      ->allow_extra_args(false);
  command->add_option("--out", arguments->out, "Results folder (default: results/<date-time>)");
  command
      ->add_option("--set", arguments->assignments, "Section.key=value, before what the ini says")
      ->allow_extra_args(false);
  command->add_flag("--verbose,-v", arguments->verbose, "Show the whole log, not only warnings");
  command->callback([arguments, &common] {
    catchInterrupt();
    run(*arguments, common);
  });
}

}  // namespace vir::app
