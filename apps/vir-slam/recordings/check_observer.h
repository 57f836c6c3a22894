#pragma once
/// What a brief check sees in the input of a run becomes part of its verdict.
#include <string>
#include <utility>
#include <vector>

#include "recordings/recording_check.h"
#include "vir/core/settings.h"
#include "vir/results/run_observer.h"

namespace vir::app {

class CheckObserver final : public results::RunObserver {
 public:
  /// `check` is fed by others and read at the end; it must outlive this. `used`: the run's own ini,
  /// which says which cameras it leaves alone.
  CheckObserver(const RecordingCheck& check, Settings used)
      : check_(check), used_(std::move(used)) {}
  /// What is more than a note and concerns the run, a line each.
  std::vector<std::string> lines() const;
  void onEnd(const roles::Estimator& estimator, results::RunSummary* summary) override;

 private:
  const RecordingCheck& check_;
  Settings used_;
};

}  // namespace vir::app
