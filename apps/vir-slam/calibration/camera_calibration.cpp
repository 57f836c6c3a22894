#include "calibration/camera_calibration.h"

#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "output/console.h"
#include "setup/prepared_run.h"
#include "vir/core/angles.h"
#include "vir/core/scratch_folder.h"
#include "vir/geometry/so3.h"
#include "vir/results/calibration_yaml.h"
#include "vir/runs/offline_run.h"

namespace vir::app {
namespace {

/// Several recordings tell the lens, whatever a single run makes of it.
constexpr const char* kEstimateLens = "Window.lens=free";

results::RunSummary runOnce(const CameraCalibrationJob& job, const std::string& recording,
                            const std::string& calibration, const std::string& out,
                            const Common& common) {
  RunArguments arguments;
  arguments.ini = job.ini;
  arguments.rawlog = recording;
  arguments.out = out;
  arguments.calibration = calibration;
  arguments.assignments = {kEstimateLens};
  arguments.assignments.insert(arguments.assignments.end(), job.assignments.begin(),
                               job.assignments.end());
  arguments.assignments.emplace_back("Estimator.calibrate=online");
  PreparedRun prepared = prepareRun(arguments, common);
  const results::ResultsFolder folder(out);
  ProgressBar bar;
  runs::OfflineRunHooks hooks;
  hooks.progress = [&](double part) { bar.show(part); };
  hooks.stop = interrupted;
  hooks.prepare = [&](mrpt::obs::CObservation* o) { prepared.calibration.apply(o); };
  return runs::runOffline(*prepared.estimator,
                          offlineOptions(prepared.options, prepared.inputs, hooks.log), folder,
                          hooks);
}

/// All recordings once, from `calibration` (a file; empty: what they say).
std::vector<runs::CalibrationRun> pass(const CameraCalibrationJob& job,
                                       const std::string& calibration, const std::string& out,
                                       const Common& common, CameraCalibrationResult* result) {
  std::vector<runs::CalibrationRun> found;
  result->doubts.clear();
  result->complete = true;
  for (const std::string& recording : job.recordings) {
    const results::RunSummary s = runOnce(job, recording, calibration, out, common);
    if (interrupted()) throw std::runtime_error("interrupted: nothing was written");
    for (const std::string& doubt : s.doubts) result->doubts.push_back(recording + ": " + doubt);
    const bool whole = s.error.empty() && !s.damaged;
    const bool useful =
        s.poses > 0 && s.calibration && s.calibration_covariance && s.calibration_given;
    if (useful) {
      found.push_back({*s.calibration_given, s.calibration_assumed.value_or(CalibrationSigma()),
                       *s.calibration, *s.calibration_covariance});
      const CameraCalibration &mine = found.back().given.camera,
                              &first = found.front().given.camera;
      if (mine.width != first.width || mine.height != first.height) {
        throw UsageError("images of " + recording + " have another size than those of " +
                         job.recordings.front() + ": one camera at a time");
      }
    }
    if (useful && whole) continue;
    result->complete = false;
    std::fprintf(stderr, "vir-slam: %s %s%s\n", recording.c_str(),
                 useful ? "ends early" : "left out: no calibration was found",
                 s.error.empty() ? "" : (": " + s.error).c_str());
  }
  return found;
}

/// A run that begins a little elsewhere drops other sights, and ends a little elsewhere: passes
/// scatter about where they settle, however many there are. So it is their mean that settles, and
/// their scatter is part of what is not known. Without the first, which began far away.
class PassMean {
 public:
  void add(const Calibration& given, runs::PooledCalibration* pooled) {
    const CalibrationChange x = changeBetween(given, pooled->calibration);
    ++count_;
    const CalibrationChange step = x - mean_;
    mean_ += step / count_;
    squares_ += step.cwiseProduct(x - mean_);
    pooled->calibration = changed(given, mean_);
    if (count_ < 2) return;
    const CalibrationChange scatter = squares_ / (count_ - 1);
    pooled->sigma = (pooled->sigma.cwiseAbs2() + scatter).cwiseSqrt().cwiseMin(pooled->assumed);
  }

 private:
  int count_ = 0;
  CalibrationChange mean_ = CalibrationChange::Zero(), squares_ = CalibrationChange::Zero();
};

}  // namespace

CameraCalibrationResult calibrateCamera(const CameraCalibrationJob& job, const Common& common) {
  for (const std::string& recording : job.recordings) requireFile(recording, "recording");
  catchInterrupt();
  const ScratchFolder scratch("vir-slam-calibrate");
  CameraCalibrationResult result;
  std::string file = job.calibration;
  CalibrationSigma assumed;
  Calibration before;
  PassMean mean;
  while (result.passes < job.passes && !result.converged) {
    const auto found = pass(job, file, (scratch / "run").string(), common, &result);
    if (found.empty()) {
      throw std::runtime_error(
          "no recording says anything of the calibration: no pose, or an estimator without a "
          "camera (`vir-slam run` and `vir-slam check` tell more)");
    }
    if (result.passes == 0) {
      before = result.given = found.front().given;
      assumed = found.front().assumed;
    }
    ++result.passes;
    result.found = runs::pooledCalibration(result.given, assumed, found);
    if (result.passes > 1) mean.add(result.given, &result.found);
    const Calibration& now = result.found.calibration;
    result.last_change_sigma = runs::largestChange(before, now, result.found.sigma);
    // The first pass began elsewhere: only those after the second can tell whether it has arrived.
    result.converged = result.passes > 2 && result.last_change_sigma < job.converged_sigma;
    std::fprintf(stderr, "pass %d: %zu recordings, largest change %.2f sigma\n", result.passes,
                 found.size(), result.last_change_sigma);
    before = now;
    // What is assumed stays what it was: what the recordings say must not count again.
    file = (scratch / "calibration.yaml").string();
    results::writeTextFile(file, results::calibrationYaml(now, assumed));
  }
  return result;
}

namespace {

using Index = CalibrationIndex;

struct Line {
  const char* name;
  int index;
  double given, found, unit;
};

std::vector<Line> linesOf(const CameraCalibrationResult& r) {
  const Calibration &g = r.given, &f = r.found.calibration;
  const auto lens = radialCoefficients(f.camera.distortion);
  // A turn against what was given says more than two attitudes.
  const Vec3 turn = logQuat(g.T_B_C.q.conjugate() * f.T_B_C.q);
  return {
      {"time offset [ms]", Index::time_offset, g.time_offset_s, f.time_offset_s, 1e-3},
      {"readout [ms]", Index::readout, g.readout_s, f.readout_s, 1e-3},
      {"fx [px]", Index::focal, g.camera.fx, f.camera.fx, 1},
      {"fy [px]", Index::focal, g.camera.fy, f.camera.fy, 1},
      {"cx [px]", Index::cx, g.camera.cx, f.camera.cx, 1},
      {"cy [px]", Index::cy, g.camera.cy, f.camera.cy, 1},
      {"first of the lens [1e-3]", Index::radial, g.camera.dist[lens[0]], f.camera.dist[lens[0]],
       1e-3},
      {"second of the lens [1e-3]", Index::radial + 1, g.camera.dist[lens[1]],
       f.camera.dist[lens[1]], 1e-3},
      {"camera x in the body [mm]", Index::position, g.T_B_C.p.x(), f.T_B_C.p.x(), 1e-3},
      {"camera y in the body [mm]", Index::position + 1, g.T_B_C.p.y(), f.T_B_C.p.y(), 1e-3},
      {"camera z in the body [mm]", Index::position + 2, g.T_B_C.p.z(), f.T_B_C.p.z(), 1e-3},
      {"camera turned about its x [deg]", Index::rotation, 0, turn.x(), kRadPerDeg},
      {"camera turned about its y [deg]", Index::rotation + 1, 0, turn.y(), kRadPerDeg},
      {"camera turned about its z [deg]", Index::rotation + 2, 0, turn.z(), kRadPerDeg},
      {"gyro gain x [%]", Index::gyro_gain, g.gyro_gain.x(), f.gyro_gain.x(), 1e-2},
      {"gyro gain y [%]", Index::gyro_gain + 1, g.gyro_gain.y(), f.gyro_gain.y(), 1e-2},
      {"gyro gain z [%]", Index::gyro_gain + 2, g.gyro_gain.z(), f.gyro_gain.z(), 1e-2},
      {"gyro axes x [deg]", Index::gyro_axes, g.gyro_axes_rad.x(), f.gyro_axes_rad.x(), kRadPerDeg},
      {"gyro axes y [deg]", Index::gyro_axes + 1, g.gyro_axes_rad.y(), f.gyro_axes_rad.y(),
       kRadPerDeg},
      {"gyro axes z [deg]", Index::gyro_axes + 2, g.gyro_axes_rad.z(), f.gyro_axes_rad.z(),
       kRadPerDeg},
      {"accelerometer gain x [%]", Index::acc_gain, g.acc_gain.x(), f.acc_gain.x(), 1e-2},
      {"accelerometer gain y [%]", Index::acc_gain + 1, g.acc_gain.y(), f.acc_gain.y(), 1e-2},
      {"accelerometer gain z [%]", Index::acc_gain + 2, g.acc_gain.z(), f.acc_gain.z(), 1e-2}};
}

}  // namespace

void printCameraCalibration(const CameraCalibrationResult& result) {
  std::printf("%-33s %10s %10s %9s\n", "", "given", "found", "sigma");
  for (const Line& line : linesOf(result)) {
    double sigma = result.found.sigma[line.index] / line.unit;
    if (line.index == Index::focal) sigma *= line.found;  // relative
    std::string note;
    if (!result.found.observed(line.index)) note = "  not observed";
    const double spread = result.found.spread[line.index];
    if (note.empty() && spread > 1.5) {
      note = "  recordings differ, sigma x " + fixed(spread, 1);
    }
    std::printf("%-33s %10.3f %10.3f %9.3f%s\n", line.name, line.given / line.unit,
                line.found / line.unit, sigma, note.c_str());
  }
}

}  // namespace vir::app
