#pragma once
/// What a brief check sees in the input of a run becomes part of its verdict.
#include "recordings/recording_check.h"
#include "vir/results/run_observer.h"

namespace vir::app {

class CheckObserver final : public results::RunObserver {
 public:
  /// `check` is fed by others and read at the end.
  explicit CheckObserver(const RecordingCheck& check) : check_(check) {}
  void onEnd(const roles::Estimator& estimator, results::RunSummary* summary) override;

 private:
  const RecordingCheck& check_;
};

}  // namespace vir::app
