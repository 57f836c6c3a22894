#include "recording.h"

#include <algorithm>
#include <stdexcept>

#include "vir/rawlog/convert.h"
#include "vir/rawlog/range_differences.h"
#include "vir/rawlog/rawlog_reader.h"

namespace vir::emulator {
namespace {

ImuMessage messageOf(const ImuSample& s) {
  ImuMessage m;
  m.acc_m_s2 = {s.acc.x(), s.acc.y(), s.acc.z()};
  m.gyro_rad_s = {s.gyro.x(), s.gyro.y(), s.gyro.z()};
  return m;
}

std::int64_t idOf(std::uint64_t anchor) { return static_cast<std::int32_t>(anchor); }

RangeItem itemOf(const Range& r) {
  // The radio's number, which MRPT keeps as 32 bits with a sign.
  RangeItem item{idOf(r.anchor), r.range_m};
  if (r.reference) item.reference = idOf(*r.reference);
  return item;
}

}  // namespace

std::vector<Event> readRecording(const std::string& rawlog, const RecordingLabels& labels) {
  rawlog::RawlogReader reader(rawlog);
  std::vector<Event> events;
  while (const auto observation = reader.next()) {
    const auto& label = observation->sensorLabel;
    if (label == labels.imu) {
      const auto sample = rawlog::imuSampleOf(*observation);
      if (sample) events.push_back({sample->t, messageOf(*sample)});
    }
    const auto asked = [&](const std::string& name) {
      return std::find(labels.ranges.begin(), labels.ranges.end(), name) != labels.ranges.end();
    };
    if (asked(rawlog::differencesName())) {
      for (const Range& r : rawlog::rangeDifferencesOf(*observation)) {
        events.push_back({r.t, itemOf(r)});
      }
    }
    if (!asked(label)) continue;
    for (const Range& r : rawlog::rangesOf(*observation)) events.push_back({r.t, itemOf(r)});
  }
  if (events.empty()) {
    throw std::runtime_error(rawlog +
                             ": holds neither ranges nor inertial readings under the "
                             "labels asked for" +
                             (reader.damage().empty() ? "" : "; " + reader.damage()));
  }
  std::stable_sort(events.begin(), events.end(),
                   [](const Event& a, const Event& b) { return a.t < b.t; });
  const TimeNs first = events.front().t;
  for (Event& e : events) e.t -= first;
  return events;
}

}  // namespace vir::emulator
