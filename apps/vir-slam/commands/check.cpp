/// vir-slam check SOURCE|FILE.rawlog: what is wrong with a recording, before it is run.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "commands/commands.h"
#include "output/check_report.h"
#include "output/console.h"
#include "output/overwrite.h"
#include "recordings/companion.h"
#include "recordings/full_check.h"
#include "setup/calibration_option.h"

namespace vir::app {
namespace fs = std::filesystem;
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
  std::vector<std::string> set, topics;
};

void run(const Arguments& a, Common& common) {
  refuseToOverwrite(a.json, Written::json, common);
  GivenCalibration calibration(a.calibration);
  for (const std::string& line : calibration.said()) std::printf("%s\n", line.c_str());
  const bool rawlog = isRawlog(a.source);
  loadPlugins(common, rawlog && fs::exists(a.source)
                          ? roles::PluginRoles{}
                          : roles::PluginRoles{roles::PluginRole::sensor});
  RecordingCheck recording(RecordingCheck::Depth::full);
  Settings settings;
  for (const std::string& assignment : calibration.assignments()) settings.set(assignment);
  const std::string companion = companionOf(a.source);
  if (!companion.empty()) settings.mergeDefaults(Settings::fromFile(companion));
  assumeAsIn(settings, &recording);
  ProgressBar bar;
  const SourceReport source = checkAll({a.source, a.set, a.calibration, a.topics}, &calibration,
                                       &recording, [&](double part) { bar.show(part); });
  bar.clear();
  for (const std::string& p : source.notes) std::printf("note: %s\n", p.c_str());
  recording.setDriver(source.driver);
  std::vector<check::Finding> findings = recording.findings();
  addFindings(source, recording.streams(), &findings);
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
  addCalibrationOption(*command, a->calibration,
                       "File that goes before the recording's own calibration");
  command
      ->add_option("--topic", a->topics,
                   "ROLE=/topic, for a recording that is imported (`vir-slam import --help`)")
      ->allow_extra_args(false);
  command->add_option("--json", a->json, "Write streams and findings here");
  command->add_option("--set", a->set, "Section.key=value of the source, e.g. euroc.camera=cam1")
      ->allow_extra_args(false);
  command->callback([a, &common] { run(*a, common); });
}

}  // namespace vir::app
