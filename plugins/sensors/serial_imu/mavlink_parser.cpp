#include "mavlink_parser.h"

#include <cstring>

#include "vir/core/crc.h"
#include "vir/core/little_endian.h"

namespace vir::serial_imu {
namespace {

constexpr int kHighres = 105, kScaled = 26, kRaw = 27;
constexpr std::uint8_t kMagic1 = 0xFE, kMagic2 = 0xFD;
constexpr std::size_t kHead1 = 6, kHead2 = 10, kCrcSize = 2, kSignatureSize = 13;
constexpr std::size_t kLongestFrame = kHead2 + 255 + kCrcSize + kSignatureSize;
constexpr std::uint8_t kSigned = 0x01;  // of the flags one must understand
constexpr double kMilliG = 9.80665e-3;
constexpr std::uint64_t kMaxMicroseconds = std::uint64_t{1} << 52;
constexpr std::uint16_t kAccAndGyro = 0x3F;  // of fields_updated

/// The messages we read: byte for the CRC, size without and with extensions.
struct Definition {
  int message;
  std::uint8_t crc_extra;
  std::size_t base_size, full_size;
};
constexpr Definition kDefinitions[] = {
    {kHighres, 93, 62, 63}, {kScaled, 170, 22, 24}, {kRaw, 144, 26, 29}};

const Definition* definitionOf(int message) {
  for (const Definition& d : kDefinitions) {
    if (d.message == message) return &d;
  }
  return nullptr;
}

void readInt16Vectors(const std::uint8_t* p, ImuReading* r) {
  for (std::size_t i = 0; i < 3; ++i) {
    r->acc_m_s2[i] = int16At(p + 2 * i) * kMilliG;
    r->gyro_rad_s[i] = int16At(p + 6 + 2 * i) * 1e-3;
  }
}

}  // namespace

MavlinkParser::MavlinkParser(const ImuLimits& limits, const MavlinkOptions& options)
    : ImuParser(limits), frames_(kLongestFrame), options_(options) {
  if (options.message == "highres") in_use_ = kHighres;
  if (options.message == "scaled") in_use_ = kScaled;
  if (options.message == "raw") in_use_ = kRaw;
}

TimeNs MavlinkParser::clockWrap() const {
  return in_use_ == kScaled ? (TimeNs{1} << 32) * 1000000 : 0;
}

/// False if there are too few bytes to tell, or (`impossible`) this is no frame.
bool MavlinkParser::header(const std::uint8_t* p, std::size_t n, Frame* f, bool* impossible) {
  *impossible = p[0] != kMagic1 && p[0] != kMagic2;
  if (*impossible) return false;
  const bool second = p[0] == kMagic2;
  f->payload = second ? kHead2 : kHead1;
  if (n < f->payload) {
    // Flags that nobody has defined: not a frame, or one we must not read.
    *impossible = second && n > 2 && (p[2] & ~kSigned) != 0;
    return false;
  }
  f->payload_size = p[1];
  f->system = p[second ? 5 : 3];
  f->component = p[second ? 6 : 4];
  f->message = second ? static_cast<int>(unsignedAt<3>(p + 7)) : p[5];
  f->size = f->payload + f->payload_size + kCrcSize;
  if (second && (p[2] & kSigned) != 0) f->size += kSignatureSize;
  *impossible = second && (p[2] & ~kSigned) != 0;
  return !*impossible;
}

long MavlinkParser::look(const std::uint8_t* p, std::size_t n) {
  Frame f;
  bool impossible = false;
  if (!header(p, n, &f, &impossible)) {
    return impossible ? FrameBuffer::kNone : FrameBuffer::kMore;
  }
  const Definition* d = definitionOf(f.message);
  // The CRC of a message we do not know cannot be checked: its bytes are passed over one by one,
  // and a frame of ours within its payload would need a right CRC of its own.
  if (d == nullptr) return FrameBuffer::kNone;
  const bool second = p[0] == kMagic2;
  const bool size_possible = second ? f.payload_size >= 1 && f.payload_size <= d->full_size
                                    : f.payload_size == d->base_size;
  if (!size_possible) return FrameBuffer::kNone;
  if (n < f.size) return FrameBuffer::kMore;
  const std::size_t end = f.payload + f.payload_size;
  const std::uint16_t crc = crc16Mavlink(&d->crc_extra, 1, crc16Mavlink(p + 1, end - 1));
  if (crc == unsignedAt<2>(p + end)) return static_cast<long>(f.size);
  ++counters_.corrupt;
  return FrameBuffer::kNone;
}

bool MavlinkParser::wanted(const Frame& f) {
  const int source = f.system << 8 | f.component;
  if (options_.system_id != 0 && f.system != options_.system_id) return false;
  if (source_ >= 0 && source != source_) return false;
  if (options_.message == "auto" && f.message != in_use_) {
    if (f.message == kRaw || (in_use_ != 0 && f.message != kHighres)) return false;
    in_use_ = f.message;
  }
  if (f.message != in_use_) return false;
  source_ = source;
  return true;
}

void MavlinkParser::feed(const std::uint8_t* bytes, std::size_t size,
                         std::vector<ImuReading>* out) {
  counters_.skipped_bytes += frames_.feed(
      bytes, size, [this](const std::uint8_t* p, std::size_t n) { return look(p, n); },
      [&](const std::uint8_t* p, std::size_t) { take(p, out); });
}

void MavlinkParser::take(const std::uint8_t* p, std::vector<ImuReading>* out) {
  Frame f;
  bool impossible = false;
  header(p, kLongestFrame, &f, &impossible);
  ++counters_.messages;
  if (!wanted(f)) {
    ++counters_.ignored;
    return;
  }
  std::uint8_t payload[255] = {};
  std::memcpy(payload, p + f.payload, f.payload_size);
  ImuReading reading;
  if (f.message == kScaled) {
    reading.device_time = static_cast<TimeNs>(unsignedAt<4>(payload)) * 1000000;
    readInt16Vectors(payload + 4, &reading);
    return give(reading, out);
  }
  const std::uint64_t microseconds = unsignedAt<8>(payload);
  if (microseconds > kMaxMicroseconds) {
    ++counters_.implausible;
    return;
  }
  reading.device_time = static_cast<TimeNs>(microseconds) * 1000;
  if (f.message == kRaw) {
    readInt16Vectors(payload + 8, &reading);
    return give(reading, out);
  }
  if ((unsignedAt<2>(payload + 60) & kAccAndGyro) != kAccAndGyro) {
    ++counters_.incomplete;
    return;
  }
  for (std::size_t i = 0; i < 3; ++i) {
    reading.acc_m_s2[i] = floatAt(payload + 8 + 4 * i);
    reading.gyro_rad_s[i] = floatAt(payload + 20 + 4 * i);
  }
  give(reading, out);
}

}  // namespace vir::serial_imu
