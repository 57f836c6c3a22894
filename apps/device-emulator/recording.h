#pragma once
#include <string>
#include <variant>
#include <vector>

#include "messages.h"
#include "vir/rawlog/labels.h"

namespace vir::emulator {

struct Event {
  TimeNs t = 0;  ///< since the first event
  std::variant<RangeItem, ImuMessage> what;
};

struct RecordingLabels {
  std::vector<std::string> ranges = {rawlog::kRangeLabel, rawlog::kPeerLabel,
                                     rawlog::differencesName()};
  std::string imu = rawlog::kImuLabel;
};

/// Ranges and inertial readings of a rawlog in time order. Throws std::runtime_error if the file
/// cannot be read or holds neither.
std::vector<Event> readRecording(const std::string& rawlog, const RecordingLabels& labels);

}  // namespace vir::emulator
