#include "binary_parser.h"

#include "vir/core/crc.h"
#include "vir/core/little_endian.h"

namespace vir::serial_imu {
namespace {

constexpr std::uint8_t kSync[] = {0xA5, 0x5A, 0x01};
constexpr std::size_t kSequence = 3, kTime = 4, kAcc = 8, kGyro = 20, kCrc = 32, kChecked = 2;

}  // namespace

void BinaryParser::reset() {
  frames_.clear();
  last_sequence_ = -1;
}

void BinaryParser::feed(const std::uint8_t* bytes, std::size_t size, std::vector<ImuReading>* out) {
  const auto look = [this](const std::uint8_t* p, std::size_t n) -> long {
    for (std::size_t i = 0; i < sizeof kSync && i < n; ++i) {
      if (p[i] != kSync[i]) return FrameBuffer::kNone;
    }
    if (n < kFrameSize) return FrameBuffer::kMore;
    if (crc16Ccitt(p + kChecked, kCrc - kChecked) == unsignedAt<2>(p + kCrc)) return kFrameSize;
    ++counters_.corrupt;
    return FrameBuffer::kNone;
  };
  counters_.skipped_bytes +=
      frames_.feed(bytes, size, look, [&](const std::uint8_t* p, std::size_t) { take(p, out); });
}

void BinaryParser::take(const std::uint8_t* frame, std::vector<ImuReading>* out) {
  ++counters_.messages;
  const int sequence = frame[kSequence];
  if (last_sequence_ >= 0) counters_.lost += (sequence - last_sequence_ + 255) % 256;
  last_sequence_ = sequence;
  ImuReading reading;
  reading.device_time = static_cast<TimeNs>(unsignedAt<4>(frame + kTime)) * 1000;
  for (std::size_t i = 0; i < 3; ++i) {
    reading.acc_m_s2[i] = floatAt(frame + kAcc + 4 * i);
    reading.gyro_rad_s[i] = floatAt(frame + kGyro + 4 * i);
  }
  give(reading, out);
}

}  // namespace vir::serial_imu
