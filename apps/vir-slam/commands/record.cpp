/// vir-slam record INI: live sensors into a rawlog, and a trajectory while they deliver.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "commands/commands.h"
#include "live/live_session.h"
#include "output/console.h"
#include "output/overwrite.h"
#include "recordings/companion.h"
#include "setup/auto_driver.h"
#include "setup/calibration_option.h"
#include "setup/given_maps.h"
#include "setup/given_survey.h"
#include "setup/record_options.h"
#include "setup/run_options.h"
#include "vir/core/host_clock.h"
#include "vir/core/settings.h"
#include "vir/live/acquisition.h"
#include "vir/roles/estimator_registry.h"

namespace vir::app {
namespace fs = std::filesystem;
namespace {

constexpr const char* kHelp =
    R"(Record live sensors, and estimate while recording
Examples:
  vir-slam record robot.ini                          until Ctrl-C
  vir-slam record robot.ini --out flight.rawlog --estimate
  vir-slam record ini/live_replay.ini --estimate     the sample recording, as if live
The ini is one of rawlog-grabber: a section per sensor. docs/live.md tells of the sensors.)";

struct Arguments {
  std::string ini, out, results, calibration, anchors, map, save_map;
  std::vector<std::string> set;
  double duration_s = -1;
  bool estimate = false, view = false, verbose = false;
};

/// Paths in an ini are relative to that ini, so that the file works from any folder.
void resolvePaths(Settings* settings, const std::vector<std::string>& sections) {
  for (const std::string& section : sections) {
    for (const char* key : {"rawlog", "image_dir_url", "ffmpeg_url"}) {
      const Setting* setting = settings->find(section, key);
      if (setting == nullptr || setting->origin.line == 0 || setting->value.empty()) continue;
      const bool address = setting->value.find("://") != std::string::npos;
      if (address || fs::path(setting->value).is_absolute()) continue;
      const fs::path path = fs::path(settings->name()).parent_path() / setting->value;
      settings->set(section + "." + key + "=" + path.lexically_normal().string());
    }
  }
}

std::string defaultOut(const std::string& ini) {
  return fs::path(ini).stem().string() + "_" + localDateTime() + ".rawlog";
}

/// The settings of the estimator, read and checked; what belongs to sensors and to rawlog-grabber
/// is none of its business.
std::unique_ptr<roles::EstimatorSettings> readEstimator(Settings settings,
                                                        const std::string& companion,
                                                        LiveSessionPlan* plan) {
  const std::vector<std::string> others = sectionsOfSensors(settings);
  settings.eraseKey(kGrabberIgnore);
  const Settings as_given = settings;
  if (!companion.empty()) settings.mergeDefaults(Settings::fromFile(companion));
  SettingsReader reader(settings);
  for (const std::string& section : others) reader.ignoreSection(section);
  for (const char* section : {"Robots", "Joint"}) reader.ignoreSection(section);
  RunOptions run;
  describe(reader, plan->options);
  describe(reader, run);
  const std::string asked = run.driver;
  run.driver = driverForLive(asked, settings, others);
  auto estimator = roles::estimatorSettings(run.driver);
  if (plan->options.estimate) refuseMixedSections(as_given, others, *estimator);
  estimator->describe(reader);
  acceptOtherDrivers(asked, run.driver, &reader);
  plan->peers.prepare(settings);
  plan->peers.describe(reader);
  reader.ignoreUnknownFrom(companion);
  reader.finish();
  plan->estimator_name = run.driver;
  plan->run = run;
  return estimator;
}

void run(const Arguments& a, Common& common) {
  pinHostClock();
  refuseToOverwrite(a.results, Written::results, common);
  requireFile(a.ini, "ini");
  Settings settings = Settings::fromFile(a.ini);
  LiveSessionPlan plan;
  plan.calibration = takeCalibration(a.calibration, a.set, &settings);
  loadPlugins(common, roles::kAllPluginRoles);
  const std::vector<std::string> sensors = live::sensorSections(settings);
  resolvePaths(&settings, sensors);
  std::string companion, recorded;  // the recording that a sensor plays
  for (const std::string& section : sensors) {
    const Setting* rawlog = settings.find(section, "rawlog");
    if (rawlog == nullptr) continue;
    if (companion.empty()) companion = companionOf(rawlog->value);
    if (recorded.empty()) recorded = rawlog->value;
  }
  takeSurvey(a.anchors, recorded, &settings);
  const bool maps = takeMaps(a.map, a.save_map, &settings);
  if (maps || a.estimate || a.view) settings.set("Recording.estimate=true");
  if (a.view) settings.set("Recording.view=true");

  plan.estimator = readEstimator(settings, companion, &plan);
  if (maps) requireImagesForMaps(plan.estimator_name, plan.estimator->inputs());
  if (a.duration_s >= 0) plan.options.duration_s = a.duration_s;
  if (!a.out.empty()) plan.options.out = a.out;
  if (plan.options.out.empty()) plan.options.out = defaultOut(a.ini);
  plan.results = a.results;
  plan.settings = settings;
  plan.verbose = a.verbose;
  common.exit_code = runLiveSession(&plan) ? kOk : kRunFailed;
}

}  // namespace

void addRecord(CLI::App& app, Common& common) {
  const auto a = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("record", kHelp);
  command->add_option("INI", a->ini, "Sensors and settings; ini/live_replay.ini is one")
      ->required();
  command->add_option("--out", a->out, "Rawlog to write; must not exist yet");
  command->add_option("--results", a->results,
                      "Results folder of --estimate (default: results/<date-time>)");
  addCalibrationOption(*command, a->calibration,
                       "File that goes before what the sensors' sections say");
  command->add_option("--anchors", a->anchors, "Table id,x,y,z,sigma of surveyed anchors");
  addMapOptions(*command, &a->map, &a->save_map);
  command->add_flag("--estimate", a->estimate, "Estimate while recording");
  command->add_flag("--view", a->view, "Show path, anchors and tracks; implies --estimate");
  command->add_option("--duration-s", a->duration_s, "End after so long")
      ->check(CLI::Range(0.0, 1e9));
  command->add_option("--set", a->set, "Section.key=value, before what the ini says")
      ->allow_extra_args(false);
  command->add_flag("--verbose,-v", a->verbose, "Show the whole log, not only warnings");
  command->callback([a, &common] {
    catchInterrupt();
    run(*a, common);
  });
}

}  // namespace vir::app
