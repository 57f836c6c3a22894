/// vir-slam export FILE.rawlog --format euroc|tum|csv --out DIR
#include <CLI/CLI.hpp>
#include <cstdio>
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
Formats: euroc = folder mav0 with images, IMU, ranges, ground truth; tum = one trajectory per label
of poses; csv = one table per label (images as a list).)";

struct Arguments {
  std::string rawlog, format, out;
};

std::unique_ptr<Exporter> makeExporter(const Arguments& a) {
  if (a.format == "tum") return makeTumExporter(a.out);
  if (a.format == "csv") return makeCsvExporter(a.out);
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
  command->add_option("FILE.rawlog", arguments->rawlog, "Recording")->required();
  command->add_option("--format", arguments->format, "euroc, tum or csv")
      ->required()
      ->check(CLI::IsMember({"euroc", "tum", "csv"}));
  command->add_option("--out", arguments->out, "Folder")->required();
  command->callback([arguments, &common] {
    requireFile(arguments->rawlog, "rawlog");
    catchInterrupt();
    if (!convert(*arguments)) common.exit_code = kRunFailed;
  });
}

}  // namespace vir::app
