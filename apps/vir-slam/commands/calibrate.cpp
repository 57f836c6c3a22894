/// vir-slam calibrate uwb RECORDING.rawlog... --anchor ID,X,Y,Z --out bias.csv
#include <CLI/CLI.hpp>
#include <cstdio>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>

#include "calibration/camera_calibration.h"
#include "commands/commands.h"
#include "output/calibration_report.h"
#include "output/overwrite.h"
#include "output/png_canvas.h"

namespace vir::app {
namespace {

constexpr const char* kExamples =
    "What sensors measure beside the truth: a camera with its IMU, or ranges\n"
    "Examples:\n"
    "  vir-slam calibrate camera a.rawlog b.rawlog --out calibration.yaml\n"
    "  vir-slam calibrate uwb hall.rawlog --anchor 0,2.1,0.4,1.8 --out bias.csv";

constexpr const char* kUwbExamples =
    "The bias of ranges as a function of distance, by a Gaussian process\n"
    "Examples:\n"
    "  vir-slam calibrate uwb hall.rawlog --anchor 0,2.1,0.4,1.8 --out bias.csv\n"
    "  vir-slam calibrate uwb a.rawlog b.rawlog --anchors anchors.csv --out bias.csv \\\n"
    "      --plot bias.svg --json bias.json\n"
    "Recordings hold ground truth (label GT) and ranges; anchors are in the ground truth's frame. "
    "One whose\n"
    "position is not given is found from its ranges where they say it.";

struct Arguments {
  std::vector<std::string> recordings, anchors;
  std::string anchor_file, out, plot, json;
};

void writeText(const std::string& path, const std::string& text, const char* what) {
  std::ofstream out(path, std::ios::binary);
  out << text;
  out.close();
  if (!out) throw std::runtime_error(std::string("cannot write ") + what + " to " + path);
}

bool endsWith(const std::string& text, const std::string& end) {
  return text.size() > end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

UwbSamples readAll(const Arguments& args, const AnchorPositions& anchors) {
  for (const std::string& file : args.recordings) requireFile(file, "recording");
  catchInterrupt();
  UwbSamples data;
  for (const std::string& file : args.recordings) addRecording(file, &data);
  fillSamples(anchors, &data);
  for (const std::string& damage : data.damage) {
    std::fprintf(stderr, "vir-slam: %s\n", damage.c_str());
  }
  for (const std::string& note : data.notes) std::fprintf(stderr, "vir-slam: %s\n", note.c_str());
  for (const auto& [id, count] : data.unknown_anchor) {
    std::fprintf(stderr,
                 "vir-slam: %ld ranges to anchor %d left out: give its position (--anchor)\n",
                 count, id);
  }
  return data;
}

int run(const Arguments& args, const Common& common) {
  refuseToOverwrite(args.out, Written::range_bias, common);
  refuseToOverwrite(args.json, Written::json, common);
  refuseToOverwrite(args.plot, Written::picture, common);
  AnchorPositions anchors;
  for (const std::string& text : args.anchors) addAnchor(text, &anchors);
  if (!args.anchor_file.empty()) addAnchorFile(args.anchor_file, &anchors);
  const UwbSamples data = readAll(args, anchors);
  ranging::RangeCalibration fit;
  try {
    fit = ranging::calibrateRangeBias(data.samples);
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(std::string(error.what()) + " (of " + std::to_string(data.ranges) +
                             " read, " + std::to_string(data.checks.rejected()) +
                             " were no usable ranges and " + std::to_string(data.without_truth) +
                             " had no ground truth)");
  }
  printTable(calibrationTable(data, fit));
  if (!fit.problem.empty()) throw std::runtime_error(fit.problem + "; nothing has been written");
  writeText(args.out, fit.model.text(), "the model");
  if (!args.json.empty()) {
    writeText(args.json, calibrationJson(data, fit).dump(2) + "\n", "JSON");
  }
  if (endsWith(args.plot, ".png")) {
    writePng(calibrationFigure(data, fit), args.plot);
  } else if (!args.plot.empty()) {
    writeText(args.plot, evaluation::toSvg(calibrationFigure(data, fit)), "the plot");
  }
  std::printf("Written to %s\n", args.out.c_str());
  return data.damage.empty() ? kOk : kRunFailed;
}

}  // namespace

void addCalibrate(CLI::App& app, Common& common) {
  const auto args = std::make_shared<Arguments>();
  CLI::App* calibrate = app.add_subcommand("calibrate", kExamples);
  calibrate->require_subcommand(1);
  addCalibrateCamera(calibrate, common);
  CLI::App* command = calibrate->add_subcommand("uwb", kUwbExamples);
  command->add_option("RECORDING", args->recordings, "Rawlogs with ground truth and ranges")
      ->required();
  command->add_option("--anchor", args->anchors, "ID,X,Y,Z of an anchor [m]; may be repeated")
      ->allow_extra_args(false);
  command->add_option("--anchors", args->anchor_file, "csv with id,x,y,z of the anchors");
  command->add_option("--out", args->out, "Write the model here (csv)")->required();
  command->add_option("--plot", args->plot, "Write a picture here: .svg, or .png");
  command->add_option("--json", args->json, "Write all numbers here");
  command->callback([args, &common] { common.exit_code = run(*args, common); });
}

}  // namespace vir::app
