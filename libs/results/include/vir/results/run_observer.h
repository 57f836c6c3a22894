#pragma once
/// Who wants to follow a run: the recorder of its files, a window, a stream, other robots.
#include "vir/roles/estimator.h"

namespace vir::results {

struct RunSummary;

/// Told of all that happens in a run, one call after the other, though live from more than one
/// thread. What an observer throws ends the run.
class RunObserver {
 public:
  virtual ~RunObserver() = default;
  /// Every observation of the recording but ground truth, before the estimator sees it (which may
  /// pass it over).
  virtual void onObservation(const mrpt::obs::CObservation& /*observation*/) {}
  /// What the estimator has made since the last call. Its landmarks, keyframes, anchors and pixels
  /// may be asked for here.
  virtual void onOutput(const roles::EstimatorOutput& /*output*/,
                        const roles::Estimator& /*estimator*/) {}
  /// The last output has been told. What the observer knows of the run goes into the summary, of
  /// which counters and warnings are there already.
  virtual void onEnd(const roles::Estimator& /*estimator*/, RunSummary* /*summary*/) {}
};

}  // namespace vir::results
