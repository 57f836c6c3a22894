#pragma once
/// How much the ranges of one anchor are worth together when their errors resemble one another from
/// one range to the next (multipath changes slowly).
#include <vector>

#include "vir/core/time.h"

namespace vir::ranging {

struct RangeResidual {
  TimeNs t = 0;
  double residual_m = 0;
  double sigma_m = 1;  ///< as claimed
};

struct RangeCorrelationOptions {
  double max_factor = 30;  ///< of the correlation alone
  double max_total_factor = 1000;
  double max_gap = 3;     ///< pairs farther apart than this many median intervals do not count
  int min_pairs = 20;     ///< with fewer, nothing is said: factor 1
  double clip_sigma = 3;  ///< outliers are cut to this many robust standard deviations
};

struct RangeCorrelation {
  double lag_one = 0;  ///< autocorrelation from one range to the next; 0 if not significant
  double correlation_factor = 1;  ///< 1 + 2 sum of the autocorrelation; (1+rho)/(1-rho) for AR(1)
  double rms_ratio = 1;           ///< rms of the residuals over the claimed sigma
  /// What each variance is to be multiplied by so that all ranges together carry the right
  /// information, rms above the claim included. Never below 1.
  double variance_factor = 1;
  int pairs = 0;
};

/// From residuals in time order; those that are not finite, or have no positive sigma, are left
/// out. The mean is not taken off: an offset that stays is the strongest correlation there is. A
/// correlation below 2/sqrt(pairs) counts as none. Where white noise lies on top of slow errors,
/// the second lag tells how slow these are.
RangeCorrelation rangeCorrelation(const std::vector<RangeResidual>& residuals,
                                  const RangeCorrelationOptions& options = {});

/// Residuals less their mean over `span_s` around, in order of time: what changes more slowly is
/// the error of a trajectory (or a bias), and taking it for the ranges' own would make them count
/// for less and less. Those with fewer than 10 within the span are left out.
std::vector<RangeResidual> withoutSlowPart(std::vector<RangeResidual> residuals, double span_s);

}  // namespace vir::ranging
