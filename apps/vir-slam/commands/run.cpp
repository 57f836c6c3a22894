/// vir-slam run INI: a recording goes in, a trajectory comes out.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "commands/auto_driver.h"
#include "commands/commands.h"
#include "commands/record_options.h"
#include "commands/run_options.h"
#include "output/console.h"
#include "recordings/companion.h"
#include "robots/peer_run.h"
#include "vir/core/ini_writer.h"
#include "vir/core/settings.h"
#include "vir/roles/estimator_registry.h"
#include "vir/runs/offline_run.h"

namespace vir::app {
namespace fs = std::filesystem;
namespace {

constexpr const char* kHelp =
    R"(Estimate the trajectory of a recording
Examples:
  vir-slam run ini/euroc.ini --rawlog mh01.rawlog
  vir-slam run ini/euroc.ini --rawlog mh01.rawlog --out results/mh01 --set Estimator.start_offset_s=10)";

struct Arguments {
  std::string ini, rawlog, out;
  std::vector<std::string> assignments;
  bool verbose = false;
};

const char* levelName(LogLevel level) {
  switch (level) {
    case LogLevel::debug:
      return "debug";
    case LogLevel::info:
      return "info";
    case LogLevel::warning:
      return "warning";
    case LogLevel::error:
      break;
  }
  return "error";
}

/// A path in an ini is relative to that ini, so that the file works from any folder.
std::string rawlogPath(const Settings& settings, const RunOptions& options) {
  if (options.rawlog.empty()) {
    throw UsageError("no recording named: give --rawlog FILE, or rawlog = FILE in [Estimator] of " +
                     settings.name());
  }
  const Setting* setting = settings.find("Estimator", "rawlog");
  const bool from_file = setting != nullptr && setting->origin.line > 0;
  if (!from_file || fs::path(options.rawlog).is_absolute()) return options.rawlog;
  return (fs::path(settings.name()).parent_path() / options.rawlog).string();
}

/// Everything a run needs, read and checked before any file is written.
struct Prepared {
  RunOptions options;
  /// Where the log goes once there is a folder for it.
  std::shared_ptr<LogSink> log = std::make_shared<LogSink>();
  std::unique_ptr<roles::Estimator> estimator;
  PeerRun peers;
  std::string used_ini, note;
};

/// What keeps an estimator from being made is a matter of its settings.
std::unique_ptr<roles::Estimator> created(const roles::EstimatorSettings& settings,
                                          const std::shared_ptr<LogSink>& log) {
  try {
    return settings.create([log](LogLevel level, const std::string& text) {
      if (*log) (*log)(level, text);
    });
  } catch (const std::exception& e) {
    throw UsageError(e.what());
  }
}

Prepared prepare(const Arguments& arguments, const Common& common) {
  Prepared run;
  Settings settings = Settings::fromFile(arguments.ini);
  for (const std::string& assignment : arguments.assignments) settings.set(assignment);
  if (!arguments.rawlog.empty()) settings.set("Estimator.rawlog=" + arguments.rawlog);
  const std::vector<std::string> of_sensors = sectionsOfSensors(settings);
  settings.eraseKey(kGrabberIgnore);
  SettingsReader own(settings);
  describe(own, run.options);
  run.options.rawlog = rawlogPath(settings, run.options);
  requireFile(run.options.rawlog, "rawlog");
  const std::string companion = companionOf(run.options.rawlog);
  if (!companion.empty()) {
    const std::size_t taken = settings.mergeDefaults(Settings::fromFile(companion));
    run.note = std::to_string(taken) + " settings of the recording taken from " + companion;
  }

  loadPlugins(common);
  const std::string asked = run.options.driver;
  run.options.driver = driverFor(asked, settings, run.options.rawlog);
  const auto estimator = roles::estimatorSettings(run.options.driver);
  run.peers.prepare(settings);
  SettingsReader reader(settings);
  // An ini of several robots will do for one of them.
  reader.ignoreSection("Robots");
  reader.ignoreSection("Joint");
  // So will that of a live recording.
  reader.ignoreSection("Recording");
  for (const std::string& section : of_sensors) reader.ignoreSection(section);
  RunOptions again;
  describe(reader, again);
  estimator->describe(reader);
  acceptOtherDrivers(asked, run.options.driver, &reader);
  run.peers.describe(reader);
  reader.ignoreUnknownFrom(companion);
  reader.finish();

  IniWriter used(IniWriter::Style::values);
  run.options.rawlog = fs::absolute(run.options.rawlog).lexically_normal().string();
  describe(used, run.options);
  estimator->describe(used);
  run.peers.describe(used);
  run.used_ini = used.text();
  run.estimator = created(*estimator, run.log);
  return run;
}

/// One row with the position, one with the error where the truth is known.
void addAnchorRows(const results::AnchorResult& anchor, std::vector<TableRow>* rows) {
  const Anchor& a = anchor.estimate;
  const std::string title = "anchor " + std::to_string(a.id);
  if (!a.has_position) {
    rows->push_back({title + " (" + name(a.state) + ")", "-", "m"});
    return;
  }
  const Vec3 sigma = a.covariance.diagonal().cwiseMax(0).cwiseSqrt();
  rows->push_back({title + " (" + name(a.state) + ")",
                   fixed(a.p_W.x(), 3) + " " + fixed(a.p_W.y(), 3) + " " + fixed(a.p_W.z(), 3),
                   "m"});
  rows->push_back({"  standard deviation",
                   fixed(sigma.x(), 3) + " " + fixed(sigma.y(), 3) + " " + fixed(sigma.z(), 3),
                   "m"});
  if (anchor.error_m) {
    rows->push_back({"  error (horizontal)",
                     fixed(*anchor.error_m, 3) + " (" + fixed(*anchor.error_horizontal_m, 3) + ")",
                     "m"});
  }
}

void addRangeRows(const results::RunSummary& s, std::vector<TableRow>* rows) {
  if (s.anchors.empty() && s.ranges_accepted + s.ranges_collected + s.ranges_rejected == 0) return;
  const auto found =
      std::count_if(s.anchors.begin(), s.anchors.end(),
                    [](const results::AnchorResult& a) { return a.estimate.has_position; });
  rows->push_back(
      {"anchors found", std::to_string(found) + " of " + std::to_string(s.anchors.size()), ""});
  for (const results::AnchorResult& a : s.anchors) addAnchorRows(a, rows);
  rows->push_back({"ranges used", std::to_string(s.ranges_accepted), ""});
  rows->push_back({"ranges before there was an anchor", std::to_string(s.ranges_collected), ""});
  rows->push_back({"ranges rejected", std::to_string(s.ranges_rejected), ""});
}

void printSummary(const results::RunSummary& s, const std::string& folder) {
  const auto optional = [](const std::optional<double>& v, int decimals) {
    return v ? fixed(*v, decimals) : std::string("-");
  };
  std::vector<TableRow> rows{
      {"images or odometry poses", std::to_string(s.frames), ""},
      {"poses", std::to_string(s.poses), ""},
      {"first pose after", optional(s.init_time_s, 2), "s"},
      {"duration", fixed(s.duration_s, 2), "s"},
      {"path", fixed(s.path_m, 2), "m"},
  };
  if (s.ate_posyaw_m) {
    rows.push_back({"ATE (position + yaw aligned)", fixed(*s.ate_posyaw_m, 4), "m"});
    rows.push_back({"ATE rotation (same alignment)", optional(s.ate_posyaw_deg, 3), "deg"});
  }
  if (s.ate_smoothed_posyaw_m) {
    rows.push_back({"ATE of the smoothed keyframes", fixed(*s.ate_smoothed_posyaw_m, 4), "m"});
  }
  addRangeRows(s, &rows);
  addPeerRows(s.peers, &rows);
  rows.push_back({"resets", std::to_string(s.resets), ""});
  rows.push_back({"CPU per image", fixed(s.cpu_ms_per_frame, 2), "ms"});
  rows.push_back({"run time", fixed(s.wall_s, 2), "s"});
  rows.push_back({"peak memory", fixed(s.peak_rss_mb, 0), "MB"});
  rows.push_back({"warnings", std::to_string(s.warnings.size()), ""});
  printTable(rows);
  for (const results::AnchorResult& a : s.anchors) {
    if (a.estimate.advice.empty()) continue;
    std::printf("anchor %llu: %s\n", static_cast<unsigned long long>(a.estimate.id),
                a.estimate.advice.c_str());
  }
  std::printf("Results in %s\n", folder.c_str());
}

void run(const Arguments& arguments, Common& common) {
  Prepared prepared = prepare(arguments, common);
  const results::ResultsFolder folder(arguments.out);
  results::writeTextFile(folder.file("used.ini"), prepared.used_ini);
  results::OutputFile log_file(folder.file("run.log"));
  ProgressBar bar;
  runs::OfflineRunHooks hooks;
  hooks.log = [&](LogLevel level, const std::string& text) {
    log_file.line(std::string(levelName(level)) + ": " + text);
    const bool shown = level == LogLevel::warning || level == LogLevel::error;
    if (!shown && !arguments.verbose) return;
    bar.clear();
    std::fprintf(stderr, "%s: %s\n", levelName(level), text.c_str());
  };
  hooks.progress = [&](double part) { bar.show(part); };
  hooks.stop = interrupted;
  if (!prepared.note.empty()) hooks.log(LogLevel::info, prepared.note);

  catchInterrupt();
  runs::OfflineRunOptions options;
  options.estimator = prepared.options.driver;
  options.rawlog = prepared.options.rawlog;
  options.start_offset_s = prepared.options.start_offset_s;
  const AnchorTable truth = anchorsTruthOf(options.rawlog);
  options.true_anchors = truth.anchors;
  if (truth.bad_lines > 0) {
    hooks.log(LogLevel::warning, std::to_string(truth.bad_lines) + " lines of " + truth.path +
                                     " are not id,x,y,z and were left out");
  }
  *prepared.log = hooks.log;
  prepared.peers.follow(hooks.log, &hooks.observers);
  const results::RunSummary summary = runs::runOffline(*prepared.estimator, options, folder, hooks);
  bar.clear();
  if (summary.poses == 0) {
    const std::string& why = summary.longest_wait_reason;
    hooks.log(LogLevel::error, "no pose at all" + (why.empty() ? "" : ": " + why));
  }
  prepared.peers.write(folder);
  results::writeTextFile(folder.file("summary.json"), toJson(summary));
  log_file.close();
  printSummary(summary, folder.path());
  if (summary.poses == 0 || !summary.error.empty()) common.exit_code = kRunFailed;
}

}  // namespace

void addRun(CLI::App& app, Common& common) {
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("run", kHelp);
  command->add_option("INI", arguments->ini, "Settings; ini/reference.ini explains every key")
      ->required();
  command->add_option("--rawlog", arguments->rawlog, "Recording (instead of the one in the ini)");
  command->add_option("--out", arguments->out, "Results folder (default: results/<date-time>)");
  command
      ->add_option("--set", arguments->assignments, "Section.key=value, before what the ini says")
      ->allow_extra_args(false);
  command->add_flag("--verbose,-v", arguments->verbose, "Show the whole log, not only warnings");
  command->callback([arguments, &common] { run(*arguments, common); });
}

}  // namespace vir::app
