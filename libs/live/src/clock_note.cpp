/// What a recording is told when somebody sets the host's clock.
#include <mrpt/obs/CObservationComment.h>

#include <cstdlib>

#include "vir/core/host_clock.h"
#include "vir/live/acquisition.h"
#include "vir/rawlog/mrpt_time.h"

namespace vir::live {
namespace {

/// What NTP shifts without a step stays below [ns].
constexpr TimeNs kNotedStep = 20'000'000;

}  // namespace

mrpt::obs::CObservation::Ptr Acquisition::clockNote(TimeNs now) {
  const TimeNs step = hostClockStep();
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (std::abs(step - clock_step_) < kNotedStep) return nullptr;
    clock_step_ = step;
  }
  const std::string text = "the host's clock was set by " + std::to_string(toSeconds(step)) +
                           " s in all since the recording began; its stamps go on as before";
  {
    const std::lock_guard<std::mutex> lock(log_mutex_);
    log(log_, LogLevel::warning, text);
  }
  auto note = std::make_shared<mrpt::obs::CObservationComment>();
  note->timestamp = rawlog::toMrptTime(now);
  note->text = text;
  return note;
}

}  // namespace vir::live
