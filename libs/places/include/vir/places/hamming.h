#pragma once
/// Binary descriptors of places.
#include <array>
#include <cstdint>
#include <cstring>

namespace vir::places {

using Descriptor = std::array<std::uint8_t, 32>;

/// Number of bits that differ, 0 to 256. Counted in all four words at a time: without the
/// processor's own instruction, which not every one has.
inline int hammingDistance(const Descriptor& a, const Descriptor& b) {
  std::uint64_t x[4], y[4];
  std::memcpy(x, a.data(), sizeof x);
  std::memcpy(y, b.data(), sizeof y);
  std::uint64_t pairs[2] = {0, 0};
  for (int k = 0; k < 4; ++k) {
    std::uint64_t v = x[k] ^ y[k];
    v -= (v >> 1) & 0x5555555555555555ULL;
    pairs[k / 2] += (v & 0x3333333333333333ULL) + ((v >> 2) & 0x3333333333333333ULL);
  }
  constexpr std::uint64_t kNibbles = 0x0F0F0F0F0F0F0F0FULL, kBytes = 0x00FF00FF00FF00FFULL;
  const std::uint64_t bytes = (pairs[0] & kNibbles) + ((pairs[0] >> 4) & kNibbles) +
                              (pairs[1] & kNibbles) + ((pairs[1] >> 4) & kNibbles);
  const std::uint64_t words = (bytes & kBytes) + ((bytes >> 8) & kBytes);
  return static_cast<int>((words * 0x0001000100010001ULL) >> 48);
}

}  // namespace vir::places
