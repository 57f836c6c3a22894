/// vir-slam export FILE.rawlog|RUN_DIR --format euroc|tum|csv|mcap --out DIR|FILE
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>

#include "commands/commands.h"
#include "output/console.h"
#include "recordings/companion.h"
#include "recordings/exporter.h"
#include "vir/rawlog/rawlog_reader.h"
#include "vir/rawlog/time_orderer.h"

namespace vir::app {
namespace {

constexpr const char* kHelp =
    R"(Write a recording in another format
Examples:
  vir-slam export mh01.rawlog --format euroc --out mh01_folder
  vir-slam export mh01.rawlog --format tum --out mh01_poses
  vir-slam export mh01.rawlog --format mcap --out mh01.mcap
  vir-slam export results/latest --format mcap --out run.mcap
Formats: euroc = folder mav0 with images, IMU, ranges, ground truth; tum = one trajectory per label
of poses; csv = one table per label (images as a list); mcap = one file with standard messages of
ROS 2, for Foxglove and Rerun: a recording, or trajectory, anchors and landmarks of a run's folder.)";

struct Arguments {
  std::string rawlog, format, out;
};

std::unique_ptr<Exporter> makeExporter(const Arguments& a) {
  if (a.format == "tum") return makeTumExporter(a.out);
  if (a.format == "csv") return makeCsvExporter(a.out);
  if (a.format == "mcap") return makeMcapExporter(a.out);
  return makeEurocExporter(a.out, companionOf(a.rawlog));
}

struct Count {
  long written = 0, left_out = 0;
};

/// Returns false if the recording turned out to be damaged.
bool convert(const Arguments& a) {
  rawlog::RawlogReader reader(a.rawlog);
  rawlog::TimeOrderer orderer;
  const auto exporter = makeExporter(a);
  std::map<std::string, Count> counts;
  ProgressBar bar;
  bool more = true;
  while (more && !interrupted()) {
    const auto observation = reader.next();
    more = observation != nullptr;
    if (more) {
      orderer.push(observation);
    } else {
      orderer.flush();
    }
    while (const auto next = orderer.pop()) {
      Count& count = counts[next->sensorLabel];
      ++(exporter->add(*next) ? count.written : count.left_out);
    }
    bar.show(reader.progress());
  }
  exporter->finish();
  bar.clear();
  std::printf("%-16s %10s %10s\n", "label", "written", "left out");
  for (const auto& [label, count] : counts) {
    std::printf("%-16s %10ld %10ld\n", label.c_str(), count.written, count.left_out);
  }
  for (const auto& [name, count] : orderer.counters()) {
    std::printf("left out for its stamp: %s %ld\n", name.c_str(), count);
  }
  if (interrupted())
    std::fprintf(stderr, "vir-slam: interrupted; %s is not complete\n", a.out.c_str());
  if (!reader.damage().empty()) std::fprintf(stderr, "vir-slam: %s\n", reader.damage().c_str());
  std::printf("Written to %s\n", a.out.c_str());
  return reader.damage().empty() && !interrupted();
}

}  // namespace

void addExport(CLI::App& app, Common& common) {
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("export", kHelp);
  command
      ->add_option("FILE.rawlog", arguments->rawlog,
                   "Recording; with mcap also the folder of a run")
      ->required();
  command->add_option("--format", arguments->format, "euroc, tum, csv or mcap")
      ->required()
      ->check(CLI::IsMember({"euroc", "tum", "csv", "mcap"}));
  command->add_option("--out", arguments->out, "Folder, or the .mcap file")->required();
  command->callback([arguments, &common] {
    if (std::filesystem::is_directory(arguments->rawlog)) {
      if (arguments->format != "mcap") {
        throw UsageError(arguments->rawlog + " is a folder; runs are exported with --format mcap");
      }
      requireFile(arguments->rawlog + "/trajectory.tum", "trajectory");
      exportRunToMcap(arguments->rawlog, arguments->out);
      std::printf("Written to %s\n", arguments->out.c_str());
      return;
    }
    requireFile(arguments->rawlog, "rawlog");
    catchInterrupt();
    if (!convert(*arguments)) common.exit_code = kRunFailed;
  });
}

}  // namespace vir::app
