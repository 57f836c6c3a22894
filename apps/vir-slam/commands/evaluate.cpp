/// vir-slam evaluate: estimates against a reference as a table, JSON and a plot.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "commands/commands.h"
#include "output/evaluation_report.h"
#include "output/overwrite.h"
#include "output/picture_file.h"
#include "recordings/trajectory_file.h"
#include "vir/evaluation/likely_mistakes.h"
#include "vir/results/results_folder.h"

namespace vir::app {
namespace {

constexpr const char* kExamples =
    "Compare trajectories with a reference\n"
    "Examples:\n"
    "  vir-slam evaluate --reference groundtruth.tum results/latest/trajectory.tum\n"
    "  vir-slam evaluate --reference mav0/state_groundtruth_estimate0/data.csv a.tum b.tum \\\n"
    "      --align se3 --json comparison.json --plot comparison.svg\n"
    "  vir-slam evaluate --reference vicon.csv --reference leica.txt trajectory.tum\n"
    "Trajectories are TUM files (t x y z qx qy qz qw, seconds), EuRoC ground truth (csv, ns), or\n"
    "tables with a header that names their columns; positions alone will do for a reference.";

struct Arguments {
  std::vector<std::string> references;
  std::vector<std::string> estimates;
  std::string align = "posyaw";
  double max_gap_s = 0.1;
  std::string images, json, plot;
};

/// File names need not be UTF-8, JSON must be.
std::string jsonText(const nlohmann::json& json) {
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

std::vector<Evaluated> evaluateAll(const Arguments& args,
                                   const evaluation::EvaluationOptions& options,
                                   const Trajectory& reference, const std::vector<TimeNs>& images) {
  std::vector<Evaluated> all;
  const std::vector<std::string> names = shortNames(args.estimates);
  for (std::size_t i = 0; i < args.estimates.size(); ++i) {
    Evaluated e;
    e.file = args.estimates[i];
    e.name = names[i];
    const Trajectory estimate = readTrajectoryFile(e.file, "trajectory", &e.read);
    if (!args.images.empty()) e.images = imageCoverage(images, estimate);
    try {
      evaluation::EvaluationOptions own = options;
      own.positions_only = options.positions_only || e.read.positions_only;
      e.result = evaluation::evaluate(reference, estimate, own);
      e.hints = evaluation::likelyMistakes(reference, estimate, own, *e.result);
      sayNotes(e);
    } catch (const evaluation::EvaluationError& error) {
      e.error = error.what();
    }
    all.push_back(std::move(e));
  }
  return all;
}

/// One table; its numbers go to `json`. Returns the exit code.
int compareWith(const std::string& reference_file, const Arguments& args,
                evaluation::EvaluationOptions options, const std::vector<TimeNs>& images,
                const std::string& plot, nlohmann::json* json) {
  evaluation::ReadReport read;
  long left_out = 0;
  const Trajectory reference = readReferenceFile(reference_file, &read, &left_out);
  options.positions_only = read.positions_only;
  const std::vector<Evaluated> all = evaluateAll(args, options, reference, images);
  const std::string how = evaluation::describeComparison(options);
  std::fputs(evaluationTable("Reference " + reference_file + "\n" + how, all).c_str(), stdout);
  *json = evaluationJson(reference_file, options, all);
  (*json)["reference_left_out"] = left_out;
  if (!plot.empty()) writeComparison(plot, reference, all, how);
  int code = kOk;
  for (const Evaluated& e : all) {
    if (e.error.empty()) continue;
    std::fprintf(stderr, "%s: %s\n", e.file.c_str(), e.error.c_str());
    code = kRunFailed;
  }
  return code;
}

int run(const Arguments& args, const Common& common) {
  refuseToOverwrite(args.json, Written::json, common);
  refuseToOverwrite(args.plot, Written::picture, common);
  evaluation::EvaluationOptions options;
  evaluation::parseAlignment(args.align, &options.alignment);
  if (!args.plot.empty()) requirePicture("--plot", args.plot);
  if (!std::isfinite(args.max_gap_s)) throw UsageError("--max-gap-s must be a finite number");
  options.association.max_gap = fromSeconds(args.max_gap_s);
  std::vector<TimeNs> images;
  if (!args.images.empty()) images = readImageStamps(args.images);
  int code = kOk;
  nlohmann::json json, of_one;
  for (const std::string& reference : args.references) {
    const bool first = reference == args.references.front();
    if (!first) std::printf("\n");
    code = std::max(code,
                    compareWith(reference, args, options, images, first ? args.plot : "", &of_one));
    json["references"].push_back(of_one);
  }
  // One reference has the file for itself.
  if (args.references.size() == 1) json = of_one;
  if (!args.json.empty()) results::writeTextFile(args.json, jsonText(json));
  return code;
}

}  // namespace

void addEvaluate(CLI::App& app, Common& common) {
  const auto args = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("evaluate", kExamples);
  command
      ->add_option("--reference", args->references,
                   "The trajectory to compare with; given several times, one table for each")
      ->required()
      ->allow_extra_args(false);
  command->add_option("EST", args->estimates, "Estimated trajectories")->required();
  command
      ->add_option("--align", args->align,
                   "What is aligned first: posyaw (translation and yaw), se3, sim3 or none")
      ->check(CLI::IsMember({"posyaw", "se3", "sim3", "none"}))
      ->capture_default_str();
  command
      ->add_option("--max-gap-s", args->max_gap_s,
                   "The reference is not interpolated across more than this")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  command->add_option("--images", args->images,
                      "csv whose first column is the stamp of an image in ns: count those covered");
  command->add_option("--json", args->json, "Write all numbers here");
  command->add_option("--plot", args->plot, "Write a picture here: .svg, or .png");
  command->callback([args, &common] { common.exit_code = run(*args, common); });
}

}  // namespace vir::app
