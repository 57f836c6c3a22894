#pragma once
/// What several runs say together of one calibration.
#include <vector>

#include "vir/types/calibration_change.h"

namespace vir::runs {

/// What one run began with, and what it found.
struct CalibrationRun {
  Calibration given;
  CalibrationSigma assumed;  ///< how far `given` was taken to be off
  Calibration found;
  CalibrationCovariance covariance;  ///< of `found`, with what was assumed
};

struct PooledCalibration {
  Calibration calibration;
  CalibrationChange sigma;     ///< standard deviations
  CalibrationChange assumed;   ///< of what was given
  CalibrationChange spread;    ///< what `sigma` was multiplied by because the runs disagree, >= 1
  bool observed(int i) const;  ///< the runs know number i clearly better than was assumed
};

/// The information of all runs summed and that of what was assumed counted once, about `given`,
/// whatever each run began with. Where runs are further apart than their covariances allow, `sigma`
/// is larger by that (Birge's ratio), at most what was assumed. Throws std::invalid_argument
/// without runs.
PooledCalibration pooledCalibration(const Calibration& given, const CalibrationSigma& assumed,
                                    const std::vector<CalibrationRun>& runs);

/// The largest change of any number from `a` to `b`, in units of `sigma`.
double largestChange(const Calibration& a, const Calibration& b, const CalibrationChange& sigma);

}  // namespace vir::runs
