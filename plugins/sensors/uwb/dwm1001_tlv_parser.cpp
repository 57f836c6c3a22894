#include "dwm1001_tlv_parser.h"

#include <algorithm>
#include <cstring>

namespace vir::uwb {
namespace {

constexpr std::uint8_t kAnswer[] = {0x40, 0x01, 0x00, 0x41, 0x0D};
constexpr std::size_t kStatus = 2, kErrorSize = 3;
constexpr std::size_t kQuality = 17;  // of the tag's position
constexpr std::size_t kRanges = 18;   // 49 len count
constexpr std::size_t kHeadSize = 21, kAnchorSize = 20, kMaxAnchors = 12;
constexpr std::uint8_t kMaxQuality = 100, kLastError = 5;

bool anchorsAreSane(const std::uint8_t* anchors, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint8_t* a = anchors + i * kAnchorSize;
    if (a[6] > kMaxQuality || a[kAnchorSize - 1] > kMaxQuality) return false;
    for (std::size_t k = 0; k < i; ++k) {
      if (u16At(a) == u16At(anchors + k * kAnchorSize)) return false;
    }
  }
  return true;
}

}  // namespace

FrameRangeParser::Look Dwm1001TlvParser::look(const std::uint8_t* bytes, std::size_t size) const {
  if (bytes[0] != kAnswer[0]) return {Outcome::none, 0};
  if (size < kErrorSize) {
    return {size == 1 || bytes[1] == 1 ? Outcome::need_more : Outcome::none, 0};
  }
  if (bytes[1] != 1 || bytes[kStatus] > kLastError) return {Outcome::none, 0};
  if (bytes[kStatus] != 0) return {Outcome::frame, kErrorSize};
  const std::size_t seen = std::min(size, sizeof kAnswer);
  if (std::memcmp(bytes, kAnswer, seen) != 0) return {Outcome::corrupt, 0};
  if (size < kHeadSize) return {Outcome::need_more, 0};
  const std::size_t count = bytes[kRanges + 2];
  if (bytes[kQuality] > kMaxQuality || bytes[kRanges] != 0x49 || count > kMaxAnchors ||
      bytes[kRanges + 1] != 1 + count * kAnchorSize) {
    return {Outcome::corrupt, 0};
  }
  const std::size_t whole = kHeadSize + count * kAnchorSize;
  if (size < whole) return {Outcome::need_more, 0};
  return {anchorsAreSane(bytes + kHeadSize, count) ? Outcome::frame : Outcome::corrupt, whole};
}

void Dwm1001TlvParser::parseFrame(const std::uint8_t* bytes, std::size_t size,
                                  std::vector<RangeReading>* out) {
  if (size == kErrorSize) {
    ++counters_.device_errors;
    return;
  }
  ++counters_.messages;
  for (std::size_t at = kHeadSize; at < size; at += kAnchorSize) {
    RangeReading reading;
    reading.responder = u16At(bytes + at);
    reading.range_m = u32At(bytes + at + 2) / 1000.0;
    give(reading, out);
  }
}

}  // namespace vir::uwb
