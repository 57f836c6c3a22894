#include "recordings/check_observer.h"

#include "vir/results/run_recorder.h"

namespace vir::app {

void CheckObserver::onEnd(const roles::Estimator& /*estimator*/, results::RunSummary* summary) {
  for (const check::Finding& f : check_.findings()) {
    if (f.severity == check::Severity::note) continue;
    const bool unusable = f.severity == check::Severity::unusable;
    (unusable ? summary->unusable_input : summary->likely_causes).push_back(check::line(f));
  }
}

}  // namespace vir::app
