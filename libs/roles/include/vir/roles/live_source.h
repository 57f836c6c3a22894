#pragma once
#include <string>
#include <utility>
#include <vector>

#include "vir/core/log.h"
#include "vir/core/options.h"
#include "vir/types/anchor.h"
#include "vir/types/state.h"

namespace vir::roles {

struct SensorMessage {
  LogLevel level = LogLevel::info;
  std::string text;
};

/// What a live sensor offers beside mrpt::hwdrivers::CGenericSensor; found by dynamic_cast. Call
/// everything from the thread that calls doProcess().
class LiveSource {
 public:
  virtual ~LiveSource() = default;
  /// Declares the settings.
  virtual void describe(OptionVisitor& v) = 0;
  /// True while the device is there (a silent one is).
  virtual bool connected() const = 0;
  /// What came in, what was handed out and what could not be used, by name.
  virtual std::vector<std::pair<std::string, long>> counters() const = 0;
  /// What happened since the last call, one line each: unplugged, back again, protocol recognised,
  /// an unknown id, ... The same lines go to the sensor's mrpt::system::COutputLogger.
  virtual std::vector<SensorMessage> takeMessages() = 0;
  /// Does it carry to others what this robot estimates? Settled once its settings are read.
  virtual bool wantsStates() const { return false; }
  /// The newest state and the anchors as believed then.
  virtual void tell(const StateEstimate& /*estimate*/, const std::vector<Anchor>& /*anchors*/) {}
};

}  // namespace vir::roles
