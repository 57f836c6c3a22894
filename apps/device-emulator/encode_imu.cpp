#include "messages.h"
#include "vir/core/crc.h"
#include "wire.h"

namespace vir::emulator {

std::string encodeImuText(const ImuMessage& m) {
  const std::string text =
      printed("IMU,%u,%.6f,%.6f,%.6f,%.7f,%.7f,%.7f",
              static_cast<unsigned>((m.device_time / 1000) & 0xFFFFFFFF), m.acc_m_s2[0],
              m.acc_m_s2[1], m.acc_m_s2[2], m.gyro_rad_s[0], m.gyro_rad_s[1], m.gyro_rad_s[2]);
  unsigned sum = 0;
  for (const char c : text) sum ^= static_cast<unsigned char>(c);
  return text + printed("*%02X\r\n", sum);
}

std::string encodeImuBinary(const ImuMessage& m) {
  std::string out("\xA5\x5A\x01", 3);
  put(&out, m.sequence, 1);
  put(&out, static_cast<std::uint64_t>(m.device_time / 1000), 4);
  for (const double v : m.acc_m_s2) putFloat(&out, v);
  for (const double v : m.gyro_rad_s) putFloat(&out, v);
  put(&out, crc16Ccitt(bytesOf(out) + 2, out.size() - 2), 2);
  return out;
}

}  // namespace vir::emulator
