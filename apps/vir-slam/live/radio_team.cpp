#include "live/radio_team.h"

#include "vir/rawlog/labels.h"

namespace vir::app {
namespace {

constexpr TimeNs kAnchorsEvery = 1'000'000'000;

}  // namespace

const std::vector<Anchor>& StateToSensors::anchorsAt(TimeNs t, const roles::Estimator& estimator) {
  if (t >= anchors_due_ || anchors_due_ - t > kAnchorsEvery) {
    anchors_due_ = t + kAnchorsEvery;
    anchors_ = estimator.anchors();
  }
  return anchors_;
}

void StateToSensors::onOutput(const roles::EstimatorOutput& output,
                              const roles::Estimator& estimator) {
  // For the others a frame is a world as a segment is.
  if (!output.frame_changes.empty()) {
    frames_ += static_cast<int>(output.frame_changes.size());
    anchors_due_ = 0;
  }
  for (const StateEstimate& estimate : output.states) {
    if (!estimate.valid) continue;
    StateEstimate told = estimate;
    told.segment += frames_;
    acquisition_->tell(told, [&] { return anchorsAt(estimate.state.t, estimator); });
  }
}

bool setApart(const std::string& peer_label, std::size_t source,
              std::vector<live::Arrival>* arrivals) {
  bool any = false;
  for (live::Arrival& a : *arrivals) {
    if (a.sensor >= source || !rawlog::isBroadcastLabel(a.observation->sensorLabel, peer_label)) {
      continue;
    }
    a.sensor = source;
    any = true;
  }
  return any;
}

}  // namespace vir::app
