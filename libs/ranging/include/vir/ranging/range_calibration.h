#pragma once
/// From ranges with known true distances to a bias model.
#include <string>
#include <vector>

#include "vir/core/time.h"
#include "vir/ranging/gaussian_process.h"
#include "vir/ranging/range_bias_model.h"
#include "vir/ranging/range_correlation.h"

namespace vir::ranging {

struct CalibrationSample {
  TimeNs t = 0;
  int series = 0;  ///< samples of one series (one anchor in one recording) follow one another
  double distance_m = 0;  ///< true
  double residual_m = 0;  ///< measured minus true
};

struct RangeCalibrationOptions {
  double outlier_sigma = 3.5;  ///< robust standard deviations from the model beyond which a range
                               ///< counts as an outlier (no line of sight)
  int min_samples = 30;
  double node_step_m = 0.25;  ///< of the table, made longer where that would be over 400 nodes
};

struct RangeCalibration {
  RangeBiasModel model;
  GaussianProcess::Hyper hyper;
  RangeCorrelation correlation;        ///< of the residuals from the model, over all series
  double sigma_m = 0;                  ///< of one range about the model, without outliers
  double lowest_m = 0, highest_m = 0;  ///< distances that were there
  std::vector<char> outlier;           ///< per sample
  int too_long = 0, too_short = 0;     ///< outliers
  std::string problem;                 ///< why the model must not be used; empty if it may be
};

/// A robust curve first: what jumps from one stretch of distances to the next was measured past an
/// obstacle. Throws std::invalid_argument naming the numbers if there are too few samples. Samples
/// that are not finite count as outliers of neither side.
RangeCalibration calibrateRangeBias(const std::vector<CalibrationSample>& samples,
                                    const RangeCalibrationOptions& options = {});

}  // namespace vir::ranging
