#pragma once
/// Portable random numbers: the distributions of the standard library differ between libraries.
#include <cmath>
#include <cstdint>
#include <random>

namespace vir::test {

class Noise {
 public:
  explicit Noise(std::uint64_t seed) : generator_(seed) {}
  /// In [0, 1).
  double uniform() { return static_cast<double>(generator_() >> 11) * 0x1.0p-53; }
  /// Standard normal (Box and Muller).
  double normal() {
    const double u = 1 - uniform();
    return std::sqrt(-2 * std::log(u)) * std::cos(2 * M_PI * uniform());
  }

 private:
  std::mt19937_64 generator_;
};

}  // namespace vir::test
