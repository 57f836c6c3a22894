#include <algorithm>

#include "messages.h"
#include "vir/core/crc.h"
#include "wire.h"

namespace vir::emulator {
namespace {

/// A MAVLink 2 frame, zeros at the payload's end cut off.
std::string frame(int message, std::uint8_t crc_extra, std::string payload, unsigned sequence) {
  while (payload.size() > 1 && payload.back() == '\0') payload.pop_back();
  std::string out("\xFD", 1);
  put(&out, payload.size(), 1);
  put(&out, 0, 2);
  put(&out, sequence, 1);
  put(&out, 1, 1);
  put(&out, 1, 1);
  put(&out, static_cast<std::uint64_t>(message), 3);
  out += payload;
  const std::uint16_t crc = crc16Mavlink(bytesOf(out) + 1, out.size() - 1);
  put(&out, crc16Mavlink(&crc_extra, 1, crc), 2);
  return out;
}

std::uint64_t milli(double v) {
  return static_cast<std::uint64_t>(std::clamp(rounded(v * 1000), -32768LL, 32767LL));
}

}  // namespace

std::string encodeMavlinkHighres(const ImuMessage& m) {
  std::string payload;
  put(&payload, static_cast<std::uint64_t>(m.device_time / 1000), 8);
  for (const double v : m.acc_m_s2) putFloat(&payload, v);
  for (const double v : m.gyro_rad_s) putFloat(&payload, v);
  for (int i = 0; i < 3; ++i) putFloat(&payload, 0.2);  // magnetic field
  putFloat(&payload, 1013.25);
  putFloat(&payload, 0);
  putFloat(&payload, 12.5);
  putFloat(&payload, 31.5);
  put(&payload, 0x3F, 2);
  put(&payload, 0, 1);
  return frame(105, 93, payload, m.sequence);
}

std::string encodeMavlinkScaled(const ImuMessage& m) {
  std::string payload;
  put(&payload, static_cast<std::uint64_t>(m.device_time / 1000000), 4);
  for (const double v : m.acc_m_s2) put(&payload, milli(v / 9.80665), 2);
  for (const double v : m.gyro_rad_s) put(&payload, milli(v), 2);
  put(&payload, 0, 8);  // magnetic field, temperature
  return frame(26, 170, payload, m.sequence);
}

}  // namespace vir::emulator
