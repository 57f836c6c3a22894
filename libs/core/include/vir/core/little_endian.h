#pragma once
/// Numbers in the bytes of device messages, least significant byte first.
#include <cstdint>
#include <cstring>
#include <string>

namespace vir {
inline namespace core {

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

/// `bytes` bytes, least significant first.
inline void put(std::string* out, std::uint64_t v, int bytes) {
  for (int i = 0; i < bytes; ++i) *out += static_cast<char>(v >> (8 * i));
}

inline void putFloat(std::string* out, double v) {
  const auto f = static_cast<float>(v);
  std::uint32_t bits = 0;
  std::memcpy(&bits, &f, sizeof bits);
  put(out, bits, 4);
}

inline const std::uint8_t* bytesOf(const std::string& s) {
  return reinterpret_cast<const std::uint8_t*>(s.data());
}

}  // namespace core
}  // namespace vir
