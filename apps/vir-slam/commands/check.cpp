/// vir-slam check SOURCE|FILE.rawlog: what is wrong with a recording, before it is run.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "commands/commands.h"
#include "output/check_report.h"
#include "output/console.h"
#include "output/overwrite.h"
#include "recordings/companion.h"
#include "recordings/recording_check.h"
#include "recordings/source_reader.h"
#include "setup/given_calibration.h"
#include "vir/core/settings.h"

namespace vir::app {
namespace {

constexpr const char* kHelp =
    R"(Say what is wrong with a recording, and what to do
Examples:
  vir-slam check mh01.rawlog
  vir-slam check MH_01_easy --calibration camchain-imucam.yaml
  vir-slam check flight.rawlog --json check.json
Exit code: 0 fine, 3 doubtful, 1 unusable.)";

struct Arguments {
  std::string source, calibration, json;
  std::vector<std::string> set;
};

/// Densities of the ini beside a rawlog, else the estimator's own; and the camera's time offset.
void setGiven(const std::string& rawlog, const GivenCalibration& calibration,
              RecordingCheck* recording) {
  Settings settings;
  for (const std::string& assignment : calibration.assignments()) settings.set(assignment);
  const std::string companion = companionOf(rawlog);
  if (!companion.empty()) settings.mergeDefaults(Settings::fromFile(companion));
  imu::ImuNoise noise;
  SettingsReader reader(settings);
  imu::describe(reader, noise);
  recording->setNoise(noise);
  double time_offset_s = 0;
  reader.section("Camera", "");
  reader.value("time_offset_s", time_offset_s, {-10.0, 10.0}, "image stamp + offset = IMU clock");
  recording->setTimeOffset(time_offset_s);
}

void run(const Arguments& a, Common& common) {
  refuseToOverwrite(a.json, Written::json, common);
  GivenCalibration calibration(a.calibration);
  for (const std::string& line : calibration.said()) std::printf("%s\n", line.c_str());
  loadPlugins(common);
  RecordingCheck recording(RecordingCheck::Depth::full);
  setGiven(a.source, calibration, &recording);
  const bool rawlog = isRawlog(a.source);
  ProgressBar bar;
  const SourceReport source =
      readSource({a.source, a.set, a.calibration}, [&](mrpt::obs::CObservation& o, double part) {
        if (rawlog) calibration.apply(&o);  // a source has it from its driver
        recording.add(o);
        bar.show(part);
      });
  bar.clear();
  for (const std::string& p : source.notes) std::printf("note: %s\n", p.c_str());
  std::vector<check::Finding> findings = recording.findings();
  addFindings(source, &findings);
  printStreams(recording.streams());
  printFindings(findings);
  const check::Severity worst = check::worst(findings);
  std::printf("\n%s: %s\n", a.source.c_str(), verdictName(worst));
  if (!a.json.empty()) writeJson(a.json, recording, findings);
  if (worst == check::Severity::unusable) common.exit_code = kRunFailed;
  if (worst == check::Severity::doubtful) common.exit_code = kDoubtful;
}

}  // namespace

void addCheck(CLI::App& app, Common& common) {
  const auto a = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("check", kHelp);
  command->add_option("SOURCE", a->source, "A rawlog, or a recording that `import` reads")
      ->required();
  command->add_option("--calibration", a->calibration,
                      "File that goes before the recording's own calibration");
  command->add_option("--json", a->json, "Write streams and findings here");
  command->add_option("--set", a->set, "Section.key=value of the source, e.g. euroc.camera=cam1")
      ->allow_extra_args(false);
  command->callback([a, &common] { run(*a, common); });
}

}  // namespace vir::app
