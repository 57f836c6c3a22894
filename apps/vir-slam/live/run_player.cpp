#include "live/run_player.h"

#include <mrpt/obs/CObservationBeaconRanges.h>
#include <mrpt/obs/CObservationImage.h>

#include <algorithm>
#include <chrono>
#include <thread>

namespace vir::app {
namespace {

constexpr std::chrono::milliseconds kLook{20};
constexpr double kSlowest = 1.0 / 64, kFastest = 64, kJumpS = 10;

}  // namespace

const char* RunPlayer::keys() {
  return "keys in the window: blank pause, . one image, + and - speed, j 10 s ahead, q end";
}

bool RunPlayer::shown(TimeNs t) const {
  return first_ != 0 && toSeconds(t - first_) >= options_.start_s && t >= hurry_until_;
}

void RunPlayer::onObservation(const mrpt::obs::CObservation& observation) {
  using mrpt::obs::CObservation;
  const bool image = dynamic_cast<const mrpt::obs::CObservationImage*>(&observation) != nullptr;
  const bool ranges =
      dynamic_cast<const mrpt::obs::CObservationBeaconRanges*>(&observation) != nullptr;
  if (!image && !ranges) return;
  // The observation is the run's; a view keeps what it is given.
  view_.setObservation(std::dynamic_pointer_cast<CObservation>(observation.duplicateGetSmartPtr()));
}

void RunPlayer::onOutput(const roles::EstimatorOutput& output, const roles::Estimator& estimator) {
  for (const Revision& r : output.revisions) view_.setRevision(r);
  for (const StateEstimate& e : output.states) {
    if (first_ == 0) view_.setBegin(first_ = e.state.t);
    view_.setEstimate(e, estimator);
    if (!shown(e.state.t)) continue;
    view_.draw();
    if (options_.end_s > 0 && toSeconds(e.state.t - first_) >= options_.end_s) over_ = true;
    holdBack(e.state.t);
  }
  over_ = over_ || view_.closed();
}

void RunPlayer::holdBack(TimeNs t) {
  while (!over_ && !view_.closed()) {
    obey(view_.typed(), t);
    if (step_) {
      step_ = false;
      pace_.restart();
      return;
    }
    if (!paused_) {
      if (options_.speed <= 0 || t < hurry_until_) return;
      const double left = pace_.secondsUntil(t, options_.speed);
      if (left <= 0) return;
      std::this_thread::sleep_for(
          std::min(std::chrono::duration<double>(left), std::chrono::duration<double>(kLook)));
    } else {
      std::this_thread::sleep_for(kLook);
    }
    view_.draw();
  }
}

void RunPlayer::obey(char key, TimeNs t) {
  if (key == 0) return;
  pace_.restart();
  if (key == ' ') paused_ = !paused_;
  if (key == '.') paused_ = step_ = true;
  if (key == '+') options_.speed = std::min(2 * options_.speed, kFastest);
  if (key == '-') options_.speed = std::max(options_.speed / 2, kSlowest);
  if (key == 'j') hurry_until_ = t + fromSeconds(kJumpS);
  if (key == 'q') over_ = true;
}

}  // namespace vir::app
