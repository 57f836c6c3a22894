/// vir-slam run INI | FILE.rawlog | SOURCE: a recording goes in, a trajectory comes out.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "commands/commands.h"
#include "live/foxglove_stream.h"
#include "live/run_player.h"
#include "output/console.h"
#include "output/overwrite.h"
#include "output/run_table.h"
#include "recordings/check_observer.h"
#include "recordings/companion.h"
#include "recordings/full_check.h"
#include "recordings/recording_check.h"
#include "setup/calibration_option.h"
#include "setup/given_maps.h"
#include "setup/prepared_run.h"
#include "setup/run_source.h"
#include "vir/runs/offline_run.h"

namespace vir::app {
namespace {

constexpr const char* kHelp =
    R"(Estimate the trajectory of a recording
Examples:
  vir-slam run flight.bag --calibration camchain-imucam.yaml
  vir-slam run flight.mcap --topic camera=/cam0/image_raw --topic imu=/imu0 --out results/flight
  vir-slam run mh01.rawlog
  vir-slam run ini/euroc.ini --rawlog mh01.rawlog
  vir-slam run ini/euroc.ini --rawlog mh01.rawlog --calibration camchain-imucam.yaml
  vir-slam run ini/euroc.ini --rawlog mh01.rawlog --out results/mh01 --set Estimator.start_offset_s=10
  vir-slam run mh01.rawlog --foxglove                 watch it in Foxglove, at ws://localhost:8765
Exit code 1 also where the results are there but end early: interrupted, or the recording is damaged.)";

void run(const RunArguments& arguments, Common& common) {
  PreparedRun prepared = prepareRun(arguments, common);
  // Closing it does not end the run.
  const std::unique_ptr<RunWindow> window =
      arguments.view ? std::make_unique<RunWindow>() : nullptr;
  const results::ResultsFolder folder(arguments.out);
  results::writeTextFile(folder.file("used.ini"), prepared.used_ini);
  results::OutputFile log_file(folder.file("run.log"), results::OutputFile::Named::at_once);
  std::unique_ptr<FoxgloveStream> foxglove;
  if (arguments.foxglove) foxglove = showInFoxglove(prepared.foxglove, prepared.used_ini);
  ProgressBar bar;
  runs::OfflineRunHooks hooks;
  hooks.log = [&](LogLevel level, const std::string& text) {
    if (foxglove) foxglove->onLog(level, text);
    log_file.line(std::string(levelName(level)) + ": " + text);
    const bool shown = level == LogLevel::warning || level == LogLevel::error;
    if (!shown && !arguments.verbose) return;
    bar.clear();
    std::fprintf(stderr, "%s: %s\n", levelName(level), text.c_str());
  };
  hooks.progress = [&](double part) { bar.show(part); };
  hooks.stop = interrupted;
  for (const std::string& line : prepared.calibration.said()) {
    std::fprintf(stderr, "%s\n", line.c_str());
    log_file.line("info: " + line);
  }
  RecordingCheck check(RecordingCheck::Depth::brief);
  hooks.prepare = [&](mrpt::obs::CObservation* o) {
    prepared.calibration.apply(o);
    check.add(*o);
  };
  CheckObserver check_observer(check, Settings::fromText(prepared.used_ini, "used.ini"));
  hooks.observers.push_back(&check_observer);
  hooks.explain = [&] {
    bar.clear();
    std::fprintf(stderr, "the result cannot be trusted: looking for causes in the recording\n");
    return causesIn(prepared.options.rawlog, Settings::fromFile(folder.file("used.ini")),
                    prepared.calibration);
  };
  if (foxglove) hooks.observers.push_back(foxglove.get());
  if (window) hooks.observers.push_back(&window->player);
  if (!prepared.note.empty()) hooks.log(LogLevel::info, prepared.note);

  runs::OfflineRunOptions options = offlineOptions(prepared.options, prepared.inputs, hooks.log);
  const AnchorTable truth = anchorsTruthOf(options.rawlog);
  options.true_anchors = truth.anchors;
  options.anchor_texts = anchorTextsOf(options.rawlog);
  options.command = common.command;
  if (truth.bad_lines > 0) {
    hooks.log(LogLevel::warning, std::to_string(truth.bad_lines) + " lines of " + truth.path +
                                     " are not id,x,y,z and were left out");
  }
  *prepared.log = hooks.log;
  prepared.peers.follow(hooks.log, &hooks.observers);
  const results::RunSummary summary = runs::runOffline(*prepared.estimator, options, folder, hooks);
  bar.clear();
  if (summary.verdict == results::Verdict::good) {  // else they are among the doubts
    for (const std::string& line : summary.likely_causes) hooks.log(LogLevel::warning, line);
  }
  if (summary.poses == 0) {
    const std::string& why = summary.longest_wait_reason;
    hooks.log(LogLevel::error, "no pose at all" + (why.empty() ? "" : ": " + why));
  }
  prepared.peers.write(folder);
  results::writeTextFile(folder.file("summary.json"), toJson(summary));
  log_file.close();
  printRunTable(summary, folder.path());
  const bool complete = summary.error.empty() && !summary.interrupted && !summary.damaged;
  if (summary.poses == 0 || !complete) common.exit_code = kRunFailed;
}

}  // namespace

void addRun(CLI::App& app, Common& common) {
  const auto arguments = std::make_shared<RunArguments>();
  const auto source = std::make_shared<RunSource>();
  CLI::App* command = app.add_subcommand("run", kHelp);
  command
      ->add_option(
          "INI", source->what,
          "Settings (ini/reference.ini explains every key), or a rawlog, or a recording in "
          "another format, which is imported into the results folder first")
      ->required();
  command->add_option("--rawlog", arguments->rawlog, "Recording (instead of the one in the ini)");
  addCalibrationOption(*command, arguments->calibration,
                       "File that goes before the calibration in the recording");
  command->add_option("--anchors", arguments->anchors,
                      "Table id,x,y,z,sigma of surveyed anchors: results also in its frame");
  addMapOptions(*command, &arguments->map, &arguments->save_map);
  command->add_option("--out", arguments->out, "Results folder (default: results/<date-time>)");
  command
      ->add_option("--set", arguments->assignments, "Section.key=value, before what the ini says")
      ->allow_extra_args(false);
  command
      ->add_option("--topic", source->topics,
                   "ROLE=/topic, for a recording that is imported (`vir-slam import --help`)")
      ->allow_extra_args(false);
  command->add_flag("--foxglove", arguments->foxglove,
                    "Show the run in Foxglove while it goes on ([Foxglove] port, speed)");
  command->add_flag("--view", arguments->view, "Show it in a window, as fast as it was recorded");
  command->add_flag("--verbose,-v", arguments->verbose, "Show the whole log, not only warnings");
  command->callback([arguments, source, &common] {
    catchInterrupt();
    refuseToOverwrite(arguments->out, Written::results, common);
    refuseToOverwrite(arguments->save_map, Written::map, common);
    resolveSource(*source, common, arguments.get());
    run(*arguments, common);
  });
}

}  // namespace vir::app
