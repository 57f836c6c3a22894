#include "nlink_parser.h"

#include <cmath>
#include <cstring>

namespace vir::uwb {
namespace {

constexpr std::uint8_t kHead = 0x55;
constexpr std::uint8_t kTagFrame0 = 0x01, kNodeFrame0 = 0x02;
constexpr std::size_t kDataFixed = 11, kDataCount = 10, kDataNode = 4, kLongestDataFrame = 2048;
constexpr std::size_t kTagFrameSize = 128, kTagDistances = 22, kTagFloats = 46, kTagLocalTime = 108;
constexpr int kTagFloatCount = 6;  // gyro and accelerometer
constexpr std::uint8_t kHighestRole = 15;
constexpr double kBlockedGapDb = 6;
constexpr TimeNs kMs = 1000000;

/// Offsets of the frames with nodes; what is meant by them see nlink_parser.h.
struct Layout {
  std::uint8_t mark;
  std::size_t fixed, node, role, id, id_bytes, time, count;
  std::size_t node_distance;  ///< in a node; role at 0, id at 1, both RSSI behind the distance
};
constexpr Layout kLayouts[] = {
    {0x04, 119, 13, 4, 5, 1, 6, 118, 2},  // NodeFrame2
    {0x05, 21, 7, 4, 5, 1, 6, 20, 2},     // NodeFrame3
    {0x08, 24, 10, 4, 5, 4, 9, 23, 5},    // NodeFrame5
};

const Layout* layoutOf(std::uint8_t mark) {
  for (const Layout& l : kLayouts) {
    if (l.mark == mark) return &l;
  }
  return nullptr;
}

bool sumIsRight(const std::uint8_t* bytes, std::size_t size) {
  unsigned sum = 0;
  for (std::size_t i = 0; i + 1 < size; ++i) sum += bytes[i];
  return (sum & 0xFF) == bytes[size - 1];
}

float floatAt(const std::uint8_t* p) {
  const std::uint32_t bits = u32At(p);
  float v = 0;
  std::memcpy(&v, &bits, sizeof v);
  return v;
}

/// Zero, or of a size that a sensor gives.
bool isReading(float v) {
  const float size = std::abs(v);
  return v == 0 || (size > 1e-8F && size < 1e4F);
}

bool tagFrameIsSane(const std::uint8_t* bytes) {
  if (bytes[3] > kHighestRole) return false;
  for (int i = 0; i < kTagFloatCount; ++i) {
    if (!isReading(floatAt(bytes + kTagFloats + 4 * i))) return false;
  }
  return true;
}

std::int64_t idAt(const std::uint8_t* p, std::size_t bytes) {
  return bytes == 1 ? p[0] : static_cast<std::int64_t>(u32At(p));
}

bool rolesAreSane(const std::uint8_t* bytes, const Layout& l) {
  if (bytes[l.role] > kHighestRole) return false;
  for (std::size_t i = 0; i < bytes[l.count]; ++i) {
    if (bytes[l.fixed + i * l.node] > kHighestRole) return false;
  }
  return true;
}

}  // namespace

FrameRangeParser::Look NlinkParser::look(const std::uint8_t* bytes, std::size_t size) const {
  if (bytes[0] != kHead) return {Outcome::none, 0};
  if (size < 2) return {Outcome::need_more, 0};
  if (bytes[1] == kTagFrame0) {
    if (size < kTagFrameSize) return {Outcome::need_more, 0};
    const bool good = sumIsRight(bytes, kTagFrameSize) && tagFrameIsSane(bytes);
    return {good ? Outcome::frame : Outcome::corrupt, kTagFrameSize};
  }
  if (bytes[1] == kNodeFrame0) return lookAtData(bytes, size);
  const Layout* l = layoutOf(bytes[1]);
  if (l == nullptr) return {Outcome::none, 0};
  if (size < 4) return {Outcome::need_more, 0};
  const std::size_t length = u16At(bytes + 2);
  // Refused before anything is waited for: a damaged length must not swallow what follows.
  if (length < l->fixed + 1 || (length - l->fixed - 1) % l->node != 0 || length > kLongestFrame) {
    return {Outcome::corrupt, 0};
  }
  if (size < l->fixed) return {Outcome::need_more, 0};
  if (l->fixed + bytes[l->count] * l->node + 1 != length) return {Outcome::corrupt, 0};
  if (size < length) return {Outcome::need_more, 0};
  const bool good = sumIsRight(bytes, length) && rolesAreSane(bytes, *l);
  return {good ? Outcome::frame : Outcome::corrupt, length};
}

FrameRangeParser::Look NlinkParser::lookAtData(const std::uint8_t* bytes, std::size_t size) {
  if (size < 4) return {Outcome::need_more, 0};
  const std::size_t length = u16At(bytes + 2);
  if (length < kDataFixed + 1 || length > kLongestDataFrame) return {Outcome::corrupt, 0};
  if (size < kDataFixed) return {Outcome::need_more, 0};
  if (bytes[4] > kHighestRole) return {Outcome::corrupt, 0};
  // Node by node as they come, so that a damaged length is seen as soon as it can be.
  std::size_t at = kDataFixed;
  for (std::size_t i = 0; i < bytes[kDataCount]; ++i) {
    if (at + kDataNode + 1 > length) return {Outcome::corrupt, 0};
    if (size < at + kDataNode) return {Outcome::need_more, 0};
    if (bytes[at] > kHighestRole) return {Outcome::corrupt, 0};
    at += kDataNode + u16At(bytes + at + 2);
  }
  if (at + 1 != length) return {Outcome::corrupt, 0};
  if (size < length) return {Outcome::need_more, 0};
  return {sumIsRight(bytes, length) ? Outcome::frame : Outcome::corrupt, length};
}

void NlinkParser::parseDataFrame(const std::uint8_t* bytes) {
  std::size_t at = kDataFixed;
  for (std::size_t i = 0; i < bytes[kDataCount]; ++i) {
    const std::uint8_t* node = bytes + at;
    const std::size_t length = u16At(node + 2);
    data_.push_back({node[1], {node + kDataNode, node + kDataNode + length}});
    at += kDataNode + length;
  }
}

void NlinkParser::parseTagFrame(const std::uint8_t* bytes, std::vector<RangeReading>* out) {
  for (int i = 0; i < 8; ++i) {
    RangeReading reading;
    reading.responder = i;
    reading.own = bytes[2];
    reading.range_m = i24At(bytes + kTagDistances + 3 * i) / 1000.0;
    reading.device_time = u32At(bytes + kTagLocalTime) * kMs;
    give(reading, out);
  }
}

void NlinkParser::parseFrame(const std::uint8_t* bytes, std::size_t,
                             std::vector<RangeReading>* out) {
  ++counters_.messages;
  if (bytes[1] == kTagFrame0) return parseTagFrame(bytes, out);
  if (bytes[1] == kNodeFrame0) return parseDataFrame(bytes);
  const Layout& l = *layoutOf(bytes[1]);
  for (std::size_t i = 0; i < bytes[l.count]; ++i) {
    const std::uint8_t* node = bytes + l.fixed + i * l.node;
    const std::uint8_t* rssi = node + l.node_distance + 3;
    RangeReading reading;
    reading.responder = idAt(node + 1, l.id_bytes);
    reading.own = idAt(bytes + l.id, l.id_bytes);
    reading.range_m = i24At(node + l.node_distance) / 1000.0;
    reading.fp_rssi_dbm = rssi[0] / -2.0;
    reading.rssi_dbm = rssi[1] / -2.0;
    reading.line_of_sight = *reading.rssi_dbm - *reading.fp_rssi_dbm < kBlockedGapDb;
    reading.device_time = u32At(bytes + l.time) * kMs;
    give(reading, out);
  }
}

}  // namespace vir::uwb
