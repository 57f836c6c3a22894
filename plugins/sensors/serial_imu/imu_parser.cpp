#include "imu_parser.h"

#include <cmath>
#include <stdexcept>

#include "binary_parser.h"
#include "mavlink_parser.h"
#include "text_parser.h"

namespace vir::serial_imu {

void ImuParser::give(const ImuReading& reading, std::vector<ImuReading>* out) {
  bool sane = reading.device_time >= 0;
  for (std::size_t i = 0; i < 3; ++i) {
    // Written so that NaN fails.
    sane = sane && std::abs(reading.acc_m_s2[i]) <= limits_.acc_m_s2 &&
           std::abs(reading.gyro_rad_s[i]) <= limits_.gyro_rad_s;
  }
  if (!sane) {
    ++counters_.implausible;
    return;
  }
  ++counters_.readings;
  out->push_back(reading);
}

std::unique_ptr<ImuParser> makeParser(const std::string& protocol, const ImuLimits& limits,
                                      const MavlinkOptions& mavlink) {
  if (protocol == "text") return std::make_unique<TextParser>(limits);
  if (protocol == "binary") return std::make_unique<BinaryParser>(limits);
  if (protocol == "mavlink") return std::make_unique<MavlinkParser>(limits, mavlink);
  throw std::invalid_argument("no IMU protocol is called " + protocol);
}

}  // namespace vir::serial_imu
