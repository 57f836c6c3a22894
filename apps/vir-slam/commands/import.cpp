/// vir-slam import [DRIVER] SOURCE --out FILE.rawlog: a recording at full speed into a rawlog.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "commands/commands.h"
#include "output/console.h"
#include "output/overwrite.h"
#include "output/settings_text.h"
#include "recordings/import_job.h"
#include "setup/calibration_option.h"
#include "vir/rawlog/mrpt_error.h"

namespace vir::app {
namespace {

struct ImportArguments {
  std::vector<std::string> what;  ///< [DRIVER] SOURCE
  bool list = false;
  ImportJob job;
};

void run(ImportArguments* a, Common& common) {
  if (a->what.size() == 2) a->job.driver = a->what.front();
  a->job.source = a->what.back();
  loadPlugins(common, {roles::PluginRole::sensor});
  requireSource(a->job.source);
  if (!a->list && a->job.out.empty()) throw UsageError("--out FILE.rawlog is needed (or --list)");
  if (a->list) {
    std::printf("%s", listRecording(a->job).c_str());
  } else {
    refuseToOverwrite(a->job.out, Written::rawlog, common);
    if (!importRecording(a->job)) common.exit_code = kRunFailed;
  }
}

/// Below the help of `import DRIVER`: what --set can set of that driver.
std::string driverHelp(const CLI::Option& what, const Common& common) {
  if (what.results().empty()) {
    return "The settings of a driver with their defaults: vir-slam import DRIVER --help";
  }
  try {
    loadPlugins(common, {roles::PluginRole::sensor});
    return "\n" + settingsText(what.results().front());
  } catch (const std::exception& e) {
    return "No settings: " + rawlog::withoutStackTrace(e);
  }
}

}  // namespace

void addImport(CLI::App& app, Common& common) {
  const auto a = std::make_shared<ImportArguments>();
  CLI::App* command = app.add_subcommand(
      "import",
      "Turn a recording into a rawlog\n"
      "Examples:\n"
      "  vir-slam import flight.bag --list\n"
      "  vir-slam import flight.bag --calibration camchain-imucam.yaml --out flight.rawlog\n"
      "  vir-slam import flight.mcap --out flight.rawlog \\\n"
      "    --topic camera=/cam0/image_raw --topic imu=/imu0 --topic range=/uwb:anchor_id,distance\n"
      "  vir-slam import euroc MH_01_easy --out mh01.rawlog\n"
      "  vir-slam import euroc --help                      the settings of that driver\n"
      "  vir-slam import euroc room1 --out room1.rawlog --set euroc.images=embed\n"
      "  vir-slam import euroc V1_02 --out v102.rawlog \\\n"
      "    --set euroc.simulate_ranges=true --set \"euroc.anchor_m=2 0 2.5\"\n"
      "  vir-slam import euroc flight --out flight.rawlog --calibration camchain-imucam.yaml\n"
      "  vir-slam import clip.mp4 --topic imu=imu.csv --calibration cam.yaml --out clip.rawlog\n"
      "  vir-slam import pyfg tiers_AB.pyfg --out tiers_A.rawlog --set pyfg.robot=A");
  const CLI::Option* what =
      command
          ->add_option(
              "SOURCE", a->what,
              "[DRIVER] SOURCE: a file or folder; DRIVER (see `vir-slam plugins`) only where "
              "it cannot be found from the source")
          ->required()
          ->expected(1, 2);
  command->add_option("--out", a->job.out, "Rawlog to write");
  addCalibrationOption(*command, a->job.calibration, "File with camera, IMU and both together");
  command
      ->add_option("--topic", a->job.topics,
                   "ROLE=/topic[:field,field], ROLE one of camera imu accel gyro range peer "
                   "odometry truth times; none: by the types of messages")
      ->allow_extra_args(false);
  command->add_flag("--list", a->list, "Show topics, types and rates, and stop");
  command->add_option("--set", a->job.set, "Section.key=value, e.g. euroc.max_duration_s=20")
      ->allow_extra_args(false);
  command->add_option("--compression", a->job.compression, "0 (none) to 9, of the rawlog itself")
      ->check(CLI::Range(0, 9))
      ->capture_default_str();
  command->add_flag("--stereo", a->job.stereo,
                    "CAM0 and CAM1 of one stamp as one CObservationStereoImages");
  command->footer([what, &common] { return driverHelp(*what, common); });
  command->callback([a, &common] {
    catchInterrupt();
    run(a.get(), common);
  });
}

}  // namespace vir::app
