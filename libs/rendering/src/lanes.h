#pragma once
/// Neighbouring pixels that are worked on side by side, in vector registers of any processor.
#include <cmath>
#include <cstdint>
#include <cstring>

// Code for wide vectors, for processors that have them: the same bytes, faster.
#if defined(__x86_64__) && defined(__GNUC__)
#define VIR_WIDE __attribute__((target("avx2"), flatten))
#else
#define VIR_WIDE
#endif

namespace vir::rendering {

inline bool hasWideVectors() {
#if defined(__x86_64__) && defined(__GNUC__)
  return __builtin_cpu_supports("avx2") != 0;
#else
  return false;
#endif
}

constexpr int kLanes = 4;
using Floats = float __attribute__((vector_size(kLanes * sizeof(float))));
using Ints = std::int32_t __attribute__((vector_size(kLanes * sizeof(std::int32_t))));

inline Floats loaded(const float from[kLanes]) {
  Floats f;
  std::memcpy(&f, from, sizeof f);
  return f;
}
inline Floats toFloats(Ints i) { return __builtin_convertvector(i, Floats); }
/// Towards zero.
inline Ints toInts(Floats f) { return __builtin_convertvector(f, Ints); }
inline Floats largest(Floats a, Floats b) { return a < b ? b : a; }
inline Floats clamped(Floats f, Floats low, Floats high) {
  return f < low ? low : (high < f ? high : f);
}
inline Floats magnitude(Floats f) { return f < 0 ? -f : f; }
inline Floats squareRoot(Floats f) {
  for (int k = 0; k < kLanes; ++k) f[k] = std::sqrt(f[k]);
  return f;
}
inline Floats allOf(float f) { return Floats{f, f, f, f}; }
/// Base 2 logarithm of what is positive, piecewise linear between the powers of 2 (error below
/// 0.09).
inline Floats roughLog2(Floats f) {
  static_assert(sizeof(Ints) == sizeof(Floats));
  // The bits of a float: 8 of its power of 2, 23 of its fraction.
  const Ints bits = reinterpret_cast<Ints>(f) & 0x7fffffff;
  return (toFloats(bits) - 1065353216.0F) * (1.0F / 8388608.0F);
}

}  // namespace vir::rendering
