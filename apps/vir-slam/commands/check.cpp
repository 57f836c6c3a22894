/// vir-slam check SOURCE|FILE.rawlog: what is wrong with a recording, before it is run.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>

#include "commands/commands.h"
#include "output/console.h"
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
  double offset = 0;
  const Setting* setting = settings.find("Camera", "time_offset_s");
  if (setting != nullptr && std::sscanf(setting->value.c_str(), "%lf", &offset) == 1) {
    recording->setTimeOffset(offset);
  }
}

void printStreams(const std::vector<check::StreamSummary>& streams) {
  std::printf("%-8s %10s %12s %10s %12s %14s\n", "label", "count", "rate [Hz]", "span [s]",
              "jitter [ms]", "longest gap [s]");
  for (const check::StreamSummary& s : streams) {
    std::printf("%-8s %10ld %12.2f %10.2f %12.3f %14.3f\n", s.label.c_str(), s.count, s.rate_hz,
                toSeconds(s.last - s.first), 1e3 * s.jitter_s, s.longest_gap_s);
  }
}

void printFindings(const std::vector<check::Finding>& findings) {
  for (const check::Finding& f : findings) {
    std::printf("\n%s: %s: %s\n", check::name(f.severity), f.stream.c_str(), f.what.c_str());
    if (!f.evidence.empty()) std::printf("  evidence: %s\n", f.evidence.c_str());
    if (!f.remedy.empty()) std::printf("  what to do: %s\n", f.remedy.c_str());
  }
}

/// So many lines or messages that cannot be read are more than a slip.
constexpr long kManyUnreadable = 5;

/// What is wrong with the file itself, before what is wrong with what is in it.
void addFindings(const SourceReport& source, std::vector<check::Finding>* findings) {
  if (source.damaged) {
    findings->push_back({check::Severity::doubtful, "damaged", "file",
                         "it is damaged or was cut off: there should be more", "",
                         "record it anew, or copy it again; what is there can be used"});
  }
  for (const auto& [counter, n] : source.unreadable) {
    if (n < kManyUnreadable) continue;
    findings->push_back({check::Severity::doubtful, "unreadable", "file",
                         std::to_string(n) + " lines or messages are no readings and are left out",
                         counter + " " + std::to_string(n), "see the notes above"});
  }
  std::stable_sort(findings->begin(), findings->end(),
                   [](const auto& a, const auto& b) { return a.severity > b.severity; });
}

const char* verdictName(check::Severity worst) {
  return worst == check::Severity::note ? "fine" : check::name(worst);
}

void writeJson(const std::string& path, const RecordingCheck& recording,
               const std::vector<check::Finding>& findings) {
  nlohmann::ordered_json json;
  json["verdict"] = verdictName(check::worst(findings));
  json["streams"] = nlohmann::json::array();
  for (const check::StreamSummary& s : recording.streams()) {
    json["streams"].push_back({{"label", s.label},
                               {"count", s.count},
                               {"rate_hz", s.rate_hz},
                               {"first_ns", s.first},
                               {"last_ns", s.last},
                               {"jitter_s", s.jitter_s},
                               {"longest_gap_s", s.longest_gap_s},
                               {"out_of_order", s.out_of_order},
                               {"repeated", s.repeated}});
  }
  json["findings"] = nlohmann::json::array();
  for (const check::Finding& f : findings) {
    json["findings"].push_back({{"severity", check::name(f.severity)},
                                {"kind", f.kind},
                                {"stream", f.stream},
                                {"what", f.what},
                                {"evidence", f.evidence},
                                {"remedy", f.remedy}});
  }
  std::ofstream out(path, std::ios::binary);
  out << json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) << "\n";
  out.close();
  if (!out) throw std::runtime_error("cannot write JSON to " + path);
}

void run(const Arguments& a, Common& common) {
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
