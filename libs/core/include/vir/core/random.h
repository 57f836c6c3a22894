#pragma once
/// Random numbers that are the same with every standard library (std::normal_distribution and its
/// kind are not).
#include <cstdint>
#include <random>

namespace vir {
inline namespace core {

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  /// One of many independent sequences of a seed: what is drawn for one purpose does not depend on
  /// how much is drawn for another.
  Random(std::uint64_t seed, std::uint64_t stream);
  /// Uniform in [0, 1).
  double uniform();
  /// Uniform in [low, high).
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  /// A whole number below `n`, which is not 0: of all nearly equally often, as long as `n` is far
  /// from 2^64.
  std::uint64_t below(std::uint64_t n) { return engine_() % n; }
  /// Zero mean, standard deviation 1 (Box-Muller; one pair of uniforms per call).
  double normal();

 private:
  std::mt19937_64 engine_;
};

/// Well mixed 64 bits of a number (the finaliser of splitmix64, Steele et al. 2014).
std::uint64_t mixBits(std::uint64_t x);

}  // namespace core
}  // namespace vir
