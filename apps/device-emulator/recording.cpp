#include "recording.h"

#include <Eigen/Core>
//
#include <mrpt/obs/CObservationBeaconRanges.h>
#include <mrpt/obs/CObservationIMU.h>

#include <algorithm>
#include <stdexcept>

#include "vir/rawlog/mrpt_time.h"
#include "vir/rawlog/rawlog_reader.h"

namespace vir::emulator {
namespace {

using mrpt::obs::CObservationBeaconRanges;
using mrpt::obs::CObservationIMU;

ImuMessage messageOf(const CObservationIMU& o) {
  using namespace mrpt::obs;
  ImuMessage m;
  m.acc_m_s2 = {o.get(IMU_X_ACC), o.get(IMU_Y_ACC), o.get(IMU_Z_ACC)};
  m.gyro_rad_s = {o.get(IMU_WX), o.get(IMU_WY), o.get(IMU_WZ)};
  return m;
}

void addRanges(const CObservationBeaconRanges& o, TimeNs t, std::vector<Event>* events) {
  for (const auto& r : o.sensedData) {
    RangeItem item;
    item.id = r.beaconID;
    item.range_m = static_cast<double>(r.sensedDistance);
    events->push_back({t, item});
  }
}

}  // namespace

std::vector<Event> readRecording(const std::string& rawlog, const RecordingLabels& labels) {
  rawlog::RawlogReader reader(rawlog);
  std::vector<Event> events;
  while (const auto observation = reader.next()) {
    const TimeNs t = rawlog::fromMrptTime(observation->timestamp);
    const auto& label = observation->sensorLabel;
    if (const auto imu = std::dynamic_pointer_cast<CObservationIMU>(observation)) {
      if (label == labels.imu) events.push_back({t, messageOf(*imu)});
    } else if (const auto r = std::dynamic_pointer_cast<CObservationBeaconRanges>(observation)) {
      const bool wanted =
          std::find(labels.ranges.begin(), labels.ranges.end(), label) != labels.ranges.end();
      if (wanted) addRanges(*r, t, &events);
    }
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
