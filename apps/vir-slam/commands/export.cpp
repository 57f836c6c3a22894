/// vir-slam export FILE.rawlog|RUN_DIR --format euroc|tum|csv|mcap --out DIR|FILE
#include <CLI/CLI.hpp>
#include <cctype>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>

#include "commands/commands.h"
#include "output/console.h"
#include "output/overwrite.h"
#include "recordings/companion.h"
#include "recordings/exporter.h"
#include "vir/rawlog/ordered_reader.h"
#include "vir/results/output_lock.h"

namespace vir::app {
namespace fs = std::filesystem;
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
ROS 2, for Foxglove and Rerun: a recording, or trajectory, anchors and landmarks of a run's folder.
Exit code 1 if something that belongs into it is missing: a recording that is damaged or was cut off,
images that are missing, refused or unreadable.)";

struct Arguments {
  std::string rawlog, format, out;
};

std::unique_ptr<Exporter> makeExporter(const Arguments& a, bool force) {
  if (a.format == "tum") return makeTumExporter(a.out, force);
  if (a.format == "csv") return makeCsvExporter(a.out, force, anchorTextsOf(a.rawlog));
  if (a.format == "mcap") return makeMcapExporter(a.out, anchorTextsOf(a.rawlog));
  return makeEurocExporter(a.out, companionOf(a.rawlog), anchorTextsOf(a.rawlog));
}

struct Count {
  long written = 0, left_out = 0;
};

/// Labels that others chose may hold anything.
std::string shown(std::string label) {
  for (char& c : label) {
    if (std::iscntrl(static_cast<unsigned char>(c)) != 0) c = '?';
  }
  return label;
}

void makeFolderOf(const std::string& file) {
  const fs::path parent = fs::path(file).parent_path();
  if (!parent.empty()) fs::create_directories(parent);
}

/// Returns false if not all is there that should be.
bool convert(const Arguments& a, bool force) {
  rawlog::OrderedReader input(a.rawlog);
  if (a.format != "mcap") {
    fs::create_directories(a.out);
  } else {
    makeFolderOf(a.out);
  }
  const results::OutputLock lock(a.out);
  const auto exporter = makeExporter(a, force);
  std::map<std::string, Count> counts;
  long unusable = 0;
  ProgressBar bar;
  const rawlog::RawlogReader& reader = input.reader();
  while (!interrupted()) {
    const auto next = input.next();
    if (!next) break;
    Count& count = counts[next->sensorLabel];
    const Exporter::Added added = exporter->add(*next);
    ++(added == Exporter::Added::written ? count.written : count.left_out);
    if (added == Exporter::Added::unusable) ++unusable;
    bar.show(reader.progress());
  }
  bar.clear();
  if (interrupted()) throw std::runtime_error("interrupted; nothing was exported");
  exporter->finish();
  std::printf("%-16s %10s %10s\n", "label", "written", "left out");
  for (const auto& [label, count] : counts) {
    std::printf("%-16s %10ld %10ld\n", shown(label).c_str(), count.written, count.left_out);
  }
  for (const auto& [name, count] : input.orderer().counters()) {
    std::printf("left out for its stamp: %s %ld\n", name.c_str(), count);
  }
  for (const std::string& problem : {reader.damage(), reader.refusals()}) {
    if (!problem.empty()) std::fprintf(stderr, "vir-slam: %s\n", problem.c_str());
  }
  if (unusable > 0) {
    std::fprintf(stderr, "vir-slam: %ld images were left out: missing, refused or not decodable\n",
                 unusable);
  }
  std::printf("Written to %s\n", a.out.c_str());
  return reader.damage().empty() && unusable == 0;
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
    if (arguments->format == "mcap") refuseToOverwrite(arguments->out, Written::mcap, common);
    if (std::filesystem::is_directory(arguments->rawlog)) {
      if (arguments->format != "mcap") {
        throw UsageError(arguments->rawlog + " is a folder; runs are exported with --format mcap");
      }
      requireFile(arguments->rawlog + "/trajectory.tum", "trajectory");
      makeFolderOf(arguments->out);
      const results::OutputLock lock(arguments->out);
      exportRunToMcap(arguments->rawlog, arguments->out);
      std::printf("Written to %s\n", arguments->out.c_str());
      return;
    }
    requireFile(arguments->rawlog, "rawlog");
    catchInterrupt();
    if (!convert(*arguments, common.force)) common.exit_code = kRunFailed;
  });
}

}  // namespace vir::app
