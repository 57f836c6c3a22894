#pragma once
#include <cstdint>
#include <cstring>

namespace vir::serial_imu {

/// `Bytes` bytes, least significant first.
template <int Bytes>
std::uint64_t unsignedAt(const std::uint8_t* p) {
  std::uint64_t v = 0;
  for (int i = 0; i < Bytes; ++i) v |= static_cast<std::uint64_t>(p[i]) << (8 * i);
  return v;
}

inline float floatAt(const std::uint8_t* p) {
  const auto bits = static_cast<std::uint32_t>(unsignedAt<4>(p));
  float v = 0;
  std::memcpy(&v, &bits, sizeof v);
  return v;
}

inline std::int16_t int16At(const std::uint8_t* p) {
  return static_cast<std::int16_t>(unsignedAt<2>(p));
}

}  // namespace vir::serial_imu
