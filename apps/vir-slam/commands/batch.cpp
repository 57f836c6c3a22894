/// vir-slam batch INI: recordings times settings times seeds, and one table.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <thread>

#include "batch/batch_plan.h"
#include "batch/batch_run.h"
#include "batch/batch_table.h"
#include "batch/slurm_engine.h"
#include "commands/commands.h"
#include "output/console.h"
#include "vir/core/parse_number.h"
#include "vir/results/results_folder.h"

namespace vir::app {
namespace fs = std::filesystem;
namespace {

constexpr const char* kHelp =
    R"(Run a benchmark: recordings x settings x seeds, and write one table
Examples:
  vir-slam batch ini/benchmark.ini                      all of it, one process per core
  vir-slam batch ini/benchmark.ini --only eight         what has "eight" in its name
  vir-slam batch ini/benchmark.ini --shard 3/8          the third of eight machines
  vir-slam batch ini/benchmark.ini --merge              the table of what all of them did
  vir-slam batch ini/benchmark.ini --engine slurm --jobs 8   on the nodes of a cluster
  seq 4 | parallel vir-slam batch ini/benchmark.ini --jobs 1 --shard {}/4
Started again it goes on where it was interrupted; what was computed with other settings or by
another build of the program is computed again.)";

struct Arguments {
  std::string ini, out, shard = "1/1", only, engine = "local", slurm_options;
  std::vector<std::string> set, from;
  int jobs = 0;
  bool merge = false, list = false, fresh = false;
};

Shard readShard(const std::string& text) {
  Shard shard;
  const std::size_t slash = std::min(text.find('/'), text.size());
  if (!parseNumber(text.substr(0, slash), &shard.index) ||
      !parseNumber(text.substr(std::min(slash + 1, text.size())), &shard.count) ||
      shard.index < 1 || shard.index > shard.count) {
    throw UsageError("--shard " + text + ": I/N with I from 1 to N is asked for, e.g. 2/8");
  }
  return shard;
}

/// Prints the table and writes it to the folder as table.md, table.csv (a line per run) and
/// table.html.
void writeTable(const BatchPlan& plan, const Arguments& a, const std::string& out,
                const std::string& command) {
  std::vector<std::string> folders{out};
  folders.insert(folders.end(), a.from.begin(), a.from.end());
  const std::vector<BatchResult> results = readBatchResults(plan, folders);
  const std::vector<BatchRow> rows = batchRows(plan, results);
  fs::create_directories(out);
  results::writeTextFile(out + "/table.md", batchMarkdown(plan, rows));
  results::writeTextFile(out + "/table.csv", batchCsv(results));
  results::writeTextFile(out + "/table.html", batchHtml(plan, rows, results, out, command));
  std::printf("\n%s\nAll columns in %s: table.html, table.md, table.csv\n",
              batchText(plan, rows).c_str(), out.c_str());
}

void run(const Arguments& a, Common& common) {
  requireFile(a.ini, "ini");
  const BatchPlan plan = readBatchPlan(a.ini, a.set);
  const std::string out =
      a.out.empty() ? "results/batch-" + fs::path(a.ini).stem().string() : a.out;
  for (const std::string& folder : a.from) {
    if (!fs::is_directory(folder)) throw UsageError("--from: there is no folder " + folder);
  }
  if (a.merge) {
    writeTable(plan, a, out, common.command);
    return;
  }
  BatchRunOptions options;
  options.out = out;
  options.plugin_dir = common.plugin_dir;
  options.jobs = a.jobs > 0 ? a.jobs : static_cast<int>(std::thread::hardware_concurrency());
  options.jobs = std::max(1, options.jobs);
  options.shard = readShard(a.shard);
  options.only = a.only;
  options.fresh = a.fresh;
  const std::vector<std::string> work = batchWork(plan, options);
  if (work.empty()) throw UsageError("nothing to do: no run has '" + a.only + "' in its name");
  if (a.list) {
    for (const std::string& name : work) std::printf("%s\n", name.c_str());
    return;
  }
  BatchCounts counts;
  if (a.engine == "slurm") {
    counts =
        runOnSlurm(plan, options, {fs::absolute(a.ini).string(), a.set, a.slurm_options, a.jobs});
  } else {
    counts = runBatch(plan, options);
  }
  std::printf("%zu runs done, %zu were done before, %zu failed%s\n", counts.done, counts.found_done,
              counts.failed, counts.interrupted ? "; interrupted: the same command goes on" : "");
  writeTable(plan, a, out, common.command);
  if (counts.failed > 0 || counts.interrupted) common.exit_code = kRunFailed;
}

}  // namespace

void addBatch(CLI::App& app, Common& common) {
  const auto a = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("batch", kHelp);
  command->add_option("INI", a->ini, "The benchmark; ini/benchmark.ini is one")->required();
  command->add_option("--out", a->out, "Results folder (default: results/batch-<name of the ini>)");
  command->add_option("--engine", a->engine, "Where: `local`, or `slurm` as a job array")
      ->check(CLI::IsMember({"local", "slurm"}))
      ->capture_default_str();
  command->add_option("--slurm-options", a->slurm_options,
                      "For sbatch, e.g. \"--partition=long --time=02:00:00\"");
  command
      ->add_option("--jobs,-j", a->jobs,
                   "Processes at the same time (default: one per core; slurm: tasks of the "
                   "array, default one per recording)")
      ->check(CLI::Range(1, 1024));
  command->add_option("--shard", a->shard, "I/N: only part I of N, for several machines")
      ->capture_default_str();
  command->add_option("--only", a->only, "Only runs with this in `recording/setting`");
  command->add_flag("--list", a->list, "Name the runs and end");
  command->add_flag("--fresh", a->fresh, "Do again what is done");
  command->add_flag("--merge", a->merge, "Run nothing: the table of what there is");
  command->add_option("--from", a->from, "Further results folders to take runs from into the table")
      ->allow_extra_args(false);
  command->add_option("--set", a->set, "Section.key=value, e.g. Batch.seeds=\"0 1\"")
      ->allow_extra_args(false);
  command->callback([a, &common] {
    catchInterrupt();
    run(*a, common);
  });
}

}  // namespace vir::app
