#include "recordings/check_observer.h"

#include "recordings/full_check.h"
#include "vir/results/run_recorder.h"

namespace vir::app {

std::vector<std::string> CheckObserver::lines() const {
  return briefLines(check_, unusedCameras(check_, used_));
}

void CheckObserver::onEnd(const roles::Estimator& /*estimator*/, results::RunSummary* summary) {
  for (const check::Finding& f : doubtfulFindings(check_, unusedCameras(check_, used_))) {
    const bool unusable = f.severity == check::Severity::unusable;
    (unusable ? summary->unusable_input : summary->likely_causes).push_back(check::line(f));
  }
}

}  // namespace vir::app
