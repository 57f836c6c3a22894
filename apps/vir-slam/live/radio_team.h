#pragma once
#include <string>
#include <vector>

#include "vir/live/acquisition.h"
#include "vir/results/run_observer.h"

namespace vir::app {

/// This robot's estimate on its way to radios that carry it to others.
class StateToSensors final : public results::RunObserver {
 public:
  explicit StateToSensors(live::Acquisition* acquisition) : acquisition_(acquisition) {}
  /// In the thread of the estimation.
  void onOutput(const roles::EstimatorOutput& output, const roles::Estimator& estimator) override;

 private:
  const std::vector<Anchor>& anchorsAt(TimeNs t, const roles::Estimator& estimator);

  live::Acquisition* acquisition_;
  std::vector<Anchor> anchors_;
  TimeNs anchors_due_ = 0;
  int frames_ = 0;
};

/// What other robots have told comes with the ranges of a radio, but is older: it becomes that of
/// sensor number `source`, so that nobody takes the radio for late. True if there was any.
bool setApart(const std::string& peer_label, std::size_t source,
              std::vector<live::Arrival>* arrivals);

}  // namespace vir::app
