#pragma once
/// Little helpers of the encoders.
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <string>

namespace vir::emulator {

template <typename... Args>
std::string printed(const char* format, Args... args) {
  char text[512];
  const int n = std::snprintf(text, sizeof text, format, args...);
  return {text, static_cast<std::size_t>(n)};
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

inline long long rounded(double v) { return std::llround(v); }

inline void require(bool possible, const char* what) {
  if (!possible) throw std::invalid_argument(what);
}

inline const std::uint8_t* bytesOf(const std::string& s) {
  return reinterpret_cast<const std::uint8_t*>(s.data());
}

}  // namespace vir::emulator
