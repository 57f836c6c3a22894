#include "setup/prepared_run.h"

#include <filesystem>

#include "output/console.h"
#include "recordings/companion.h"
#include "setup/auto_driver.h"
#include "setup/given_maps.h"
#include "setup/given_survey.h"
#include "setup/record_options.h"
#include "vir/core/ini_writer.h"
#include "vir/core/settings.h"
#include "vir/rawlog/labels.h"
#include "vir/rawlog/mrpt_error.h"
#include "vir/roles/estimator_registry.h"
#include "vir/runs/input_labels.h"

namespace vir::app {
namespace fs = std::filesystem;
namespace {

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

/// A run must not write over what it was given: `used.ini` would then name something else.
void refuseOwnCalibration(const std::string& calibration, const std::string& out) {
  if (calibration.empty() || out.empty()) return;
  const fs::path written = fs::absolute(fs::path(out) / "calibration.yaml").lexically_normal();
  for (const std::string& path : formats::calibrationPaths(calibration)) {
    if (written != fs::path(path)) continue;
    throw UsageError("the calibration " + path +
                     " would be written over by this run: give another folder (--out)");
  }
}

/// What keeps an estimator from being made is a matter of its settings.
std::unique_ptr<roles::Estimator> created(const roles::EstimatorSettings& settings,
                                          const std::shared_ptr<LogSink>& log) {
  try {
    return settings.create([log](LogLevel level, const std::string& text) {
      if (*log) (*log)(level, text);
    });
  } catch (const std::exception& e) {
    throw UsageError(rawlog::withoutStackTrace(e));
  }
}

}  // namespace

std::string imageLabel(const std::vector<roles::EstimatorInput>& inputs) {
  for (const roles::EstimatorInput& input : inputs) {
    if (input.kind == roles::InputKind::image) return input.label;
  }
  return rawlog::kCameraLabel;
}

PreparedRun prepareRun(const RunArguments& arguments, const Common& common) {
  PreparedRun run;
  Settings settings;
  if (!arguments.ini.empty()) settings = Settings::fromFile(arguments.ini);
  run.calibration = takeCalibration(arguments.calibration, arguments.assignments, &settings);
  if (!arguments.rawlog.empty()) settings.set("Estimator.rawlog=" + arguments.rawlog);
  const std::vector<std::string> of_sensors = sectionsOfSensors(settings);
  settings.eraseKey(kGrabberIgnore);
  SettingsReader own(settings);
  describe(own, run.options);
  run.options.rawlog = rawlogPath(settings, run.options);
  requireFile(run.options.rawlog, "rawlog");
  refuseOwnCalibration(run.options.calibration, arguments.out);
  takeSurvey(arguments.anchors, run.options.rawlog, &settings);
  const bool maps = takeMaps(arguments.map, arguments.save_map, &settings);
  const std::string companion = companionOf(run.options.rawlog);
  if (!companion.empty()) {
    const std::size_t taken = settings.mergeDefaults(Settings::fromFile(companion));
    run.note = std::to_string(taken) + " settings of the recording taken from " + companion;
  }

  loadPlugins(common, {roles::PluginRole::estimator, roles::PluginRole::rendezvous});
  const std::string asked = run.options.driver;
  run.options.driver = driverFor(asked, settings, run.options.rawlog);
  const auto estimator = roles::estimatorSettings(run.options.driver);
  if (maps) requireImagesForMaps(run.options.driver, estimator->inputs());
  run.peers.prepare(settings);
  SettingsReader reader(settings);
  // An ini of several robots will do for one of them.
  reader.ignoreSection("Robots");
  reader.ignoreSection("Joint");
  // So will that of a live recording.
  for (const char* section : {"Recording", "MAVLink", "Dds"}) reader.ignoreSection(section);
  for (const std::string& section : of_sensors) reader.ignoreSection(section);
  RunOptions again;
  describe(reader, again);
  describe(reader, run.foxglove);
  estimator->describe(reader);
  acceptOtherDrivers(asked, run.options.driver, &reader);
  run.peers.describe(reader);
  reader.ignoreUnknownFrom(companion);
  reader.finish();
  run.calibration.setCameraLabel(imageLabel(estimator->inputs()));

  IniWriter used(IniWriter::Style::values);
  run.options.rawlog = fs::absolute(run.options.rawlog).lexically_normal().string();
  describe(used, run.options);
  estimator->describe(used);
  run.peers.describe(used);
  run.used_ini = used.text();
  run.inputs = estimator->inputs();
  run.estimator = created(*estimator, run.log);
  requireMapOfCamera(run.options.rawlog, imageLabel(run.inputs), run.calibration, settings);
  return run;
}

runs::OfflineRunOptions offlineOptions(const RunOptions& run,
                                       const std::vector<roles::EstimatorInput>& inputs,
                                       const LogSink& log) {
  runs::OfflineRunOptions out;
  out.estimator = run.driver;
  out.rawlog = run.rawlog;
  out.start_offset_s = run.start_offset_s;
  out.duration_s = run.duration_s;
  out.inputs = inputs;
  const runs::InputLabels labels = runs::matchLabels(out.inputs, out.rawlog);
  out.labels = labels.as;
  for (const std::string& note : labels.notes) vir::log(log, LogLevel::warning, note);
  return out;
}

}  // namespace vir::app
