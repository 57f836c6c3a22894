/// vir-slam import DRIVER SOURCE --out FILE.rawlog: a recorded sensor at full speed into a rawlog.
#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>

#include "commands/commands.h"
#include "output/console.h"
#include "recordings/rawlog_recorder.h"
#include "vir/core/settings.h"
#include "vir/roles/recorded_source.h"
#include "vir/roles/sensor_registry.h"

namespace vir::app {
namespace fs = std::filesystem;
namespace {

struct ImportArguments {
  std::string driver, source, out, calibration;
  std::vector<std::string> set;
  int compression = 1;
};

/// Configures the sensor as its section [alias] and --set say.
void configure(const ImportArguments& a, roles::RecordedSource& source) {
  Settings settings;
  for (const std::string& assignment : a.set) settings.set(assignment);
  if (!a.calibration.empty()) settings.set(a.driver + ".calibration=" + a.calibration);
  settings.set(a.driver + ".source=" + a.source);
  SettingsReader reader(settings);
  source.describe(reader);
  reader.finish();
}

void run(const ImportArguments& a, const Common& common) {
  if (a.driver == "simulator") {
    throw UsageError("'simulator' has no recording to import; use `vir-slam simulate INI`");
  }
  loadPlugins(common);
  const auto sensor = roles::createSensor(a.driver);
  auto* source = dynamic_cast<roles::RecordedSource*>(sensor.get());
  if (source == nullptr) {
    throw UsageError("'" + a.driver + "' is a live sensor; use `vir-slam record`");
  }
  requireRawlogName(a.out);
  if (!a.calibration.empty()) requireFile(a.calibration, "calibration");
  if (!fs::exists(a.source)) throw UsageError("there is no such file or folder: " + a.source);
  configure(a, *source);
  recordToRawlog({sensor.get(), source, a.out, a.compression, "import"});
}

}  // namespace

void addImport(CLI::App& app, Common& common) {
  const auto a = std::make_shared<ImportArguments>();
  CLI::App* command = app.add_subcommand(
      "import",
      "Turn a recording into a rawlog\n"
      "Examples:\n"
      "  vir-slam import euroc MH_01_easy --out mh01.rawlog\n"
      "  vir-slam import euroc room1 --out room1.rawlog --set euroc.images=embed\n"
      "  vir-slam import euroc V1_02 --out v102.rawlog \\\n"
      "    --set euroc.simulate_ranges=true --set \"euroc.anchor_m=2 0 2.5\"\n"
      "  vir-slam import euroc flight --out flight.rawlog --calibration camchain-imucam.yaml\n"
      "  vir-slam import pyfg tiers_AB.pyfg --out tiers_A.rawlog --set pyfg.robot=A");
  command->add_option("DRIVER", a->driver, "Recorded sensor: see `vir-slam plugins`")->required();
  command->add_option("SOURCE", a->source, "What it reads: a folder or a file")->required();
  command->add_option("--out", a->out, "Rawlog to write")->required();
  command->add_option("--calibration", a->calibration,
                      "File that goes before the recording's own calibration");
  command->add_option("--set", a->set, "Section.key=value, e.g. euroc.max_duration_s=20")
      ->allow_extra_args(false);
  command->add_option("--compression", a->compression, "0 (none) to 9, of the rawlog itself")
      ->check(CLI::Range(0, 9))
      ->capture_default_str();
  command->callback([a, &common] {
    catchInterrupt();
    run(*a, common);
  });
}

}  // namespace vir::app
