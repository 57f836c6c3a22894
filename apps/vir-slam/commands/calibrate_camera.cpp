/// vir-slam calibrate camera RECORDING.rawlog... --out calibration.yaml
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "calibration/camera_calibration.h"
#include "output/overwrite.h"
#include "setup/calibration_option.h"
#include "vir/results/calibration_yaml.h"
#include "vir/results/results_folder.h"

namespace vir::app {
namespace {

constexpr const char* kCameraExamples =
    "Camera and IMU: time offset, intrinsics, where they sit, gains; no ground truth needed\n"
    "Examples:\n"
    "  vir-slam calibrate camera a.rawlog b.rawlog --out calibration.yaml\n"
    "  vir-slam calibrate camera a.rawlog --calibration camchain-imucam.yaml --out results/rig\n"
    "  vir-slam run flight.rawlog --calibration calibration.yaml\n"
    "The recordings are of one camera with one IMU; turn it about all axes and move it about.\n"
    "They are run again from what was found until nothing changes by a quarter of its sigma.\n"
    "Exit code: 0 settled; 3 written but not settled or doubtful; 1 nothing found, or a\n"
    "recording could not be used to its end (written from the others).";

struct CameraArguments {
  CameraCalibrationJob job;
  std::string out = "calibration.yaml";
};

/// A file's name, or the folder that `calibration.yaml` goes into.
std::string calibrationFile(const std::string& out) {
  const bool file = std::filesystem::path(out).extension() == ".yaml" ||
                    std::filesystem::path(out).extension() == ".yml";
  return file ? out : out + "/calibration.yaml";
}

int runCamera(const CameraArguments& args, const Common& common) {
  if (args.out.empty()) throw UsageError("--out is empty: name a file or a folder");
  const std::string file = calibrationFile(args.out);
  refuseToOverwrite(file, Written::calibration, common);
  const CameraCalibrationResult result = calibrateCamera(args.job, common);
  printCameraCalibration(result);
  const std::filesystem::path folder = std::filesystem::path(file).parent_path();
  if (!folder.empty()) std::filesystem::create_directories(folder);
  results::writeTextFile(
      file, results::calibrationYaml(result.found.calibration, sigmaOf(result.found.sigma)));
  std::printf("Written to %s\n", file.c_str());
  for (const std::string& doubt : result.doubts) {
    std::fprintf(stderr, "vir-slam: doubt: %s\n", doubt.c_str());
  }
  if (!result.converged) {
    std::fprintf(
        stderr,
        "vir-slam: not settled after %d passes (last change %.1f sigma): more --passes, or "
        "recordings with more motion\n",
        result.passes, result.last_change_sigma);
  }
  if (!result.complete) return kRunFailed;
  return result.converged && result.doubts.empty() ? kOk : kDoubtful;
}

}  // namespace

void addCalibrateCamera(CLI::App* calibrate, Common& common) {
  const auto args = std::make_shared<CameraArguments>();
  CLI::App* command = calibrate->add_subcommand("camera", kCameraExamples);
  command
      ->add_option("RECORDING", args->job.recordings, "Rawlogs with images (or tracks) and an IMU")
      ->required();
  command->add_option("--out", args->out,
                      "A .yaml to write, or the folder for it (default: calibration.yaml)");
  addCalibrationOption(*command, args->job.calibration,
                       "Calibration to begin with, before the recordings' own");
  command->add_option("--ini", args->job.ini, "Settings of the estimator");
  command->add_option("--set", args->job.assignments, "Section.key=value, before what the ini says")
      ->allow_extra_args(false);
  command->add_option("--passes", args->job.passes, "Over all recordings, at most")
      ->check(CLI::Range(3, 50))
      ->capture_default_str();
  command->callback([args, &common] { common.exit_code = runCamera(*args, common); });
}

}  // namespace vir::app
