#pragma once
/// A made-up surface: a square that repeats without a seam, at every scale it may be looked at.
#include <cstdint>
#include <vector>

namespace vir::rendering {

struct TextureStyle {
  double smallest = 4, largest = 180;  ///< radii of its patches [texels]
  double round = 0.5;                  ///< share of discs; the others are rectangles
  double tilted = 1;                   ///< share of the rectangles that are turned
  double gradient = 0.3;               ///< brightness changes this much within a patch
};

/// How a pixel's area lies on a surface; the same for neighbouring pixels.
struct Footprint {
  float length = 0, log2_length = 0;  ///< [m]
  float ratio = 1;                    ///< of length and width, within what is made use of
  float du = 0, dv = 0;               ///< its length as a vector [m]
};

/// From the change of the position on the surface from a pixel to the next, right and down [m].
Footprint footprintOf(float du_dx, float dv_dx, float du_dy, float dv_dy);

/// Patches that cover each other, sizes by an inverse cube law: the statistics of natural images
/// ("dead leaves", Lee, Mumford and Huang, IJCV 2001). With it go all halvings of its resolution.
class Texture {
 public:
  static constexpr int kBits = 10;
  static constexpr int kSize = 1 << kBits;
  static constexpr int kLevels = 9;

  Texture(const TextureStyle& style, std::uint64_t seed, std::uint64_t stream);

  /// Positions in integers: texels of the finest level, 8 bits of fraction.
  struct Place {
    std::int32_t u = 0, v = 0;
  };
  static Place placeOf(float u, float v) {
    return {static_cast<std::int32_t>(u * 256.0F), static_cast<std::int32_t>(v * 256.0F)};
  }
  /// What neighbouring pixels have in common.
  struct Sampling {
    int level = 0, probes = 1;
    float coarse = 0;  ///< share of the next level
    Place step;        ///< from probe to probe
  };
  static Sampling samplingOf(const Footprint& f, float texels_per_m, float log2_texels_per_m);
  /// Neighbouring pixels that are worked on side by side, in vector registers.
  static constexpr int kLanes = 4;
  /// Grey levels about 0 (-128..127) at positions [texels]. Continuous but for the number of
  /// probes.
  void look(const Sampling& s, const float u[kLanes], const float v[kLanes],
            float out[kLanes]) const;

 private:
  /// Of a quad within its level of 2^bits by 2^bits: squares of 4 by 4 lie together, so that a
  /// small piece of a surface is near in memory whichever way it is turned.
  static std::int32_t indexOf(std::int32_t bits, std::int32_t x, std::int32_t y);
  /// 0 .. 255 * 65536: as floats still exact.
  void bilinear(int level, const std::int32_t u[kLanes], const std::int32_t v[kLanes],
                float out[kLanes]) const;
  /// Each holds a texel, its right neighbour, the one below it and that one's right neighbour, a
  /// byte each from the lowest: what bilinear interpolation needs in one access. All levels, the
  /// finest first.
  std::vector<std::uint32_t> quads_;
  std::int32_t offset_[kLevels] = {};
};

inline std::int32_t Texture::indexOf(std::int32_t bits, std::int32_t x, std::int32_t y) {
  return ((y >> 2) << (bits + 2)) | ((x >> 2) << 4) | ((y & 3) << 2) | (x & 3);
}

inline void Texture::bilinear(int level, const std::int32_t u[kLanes], const std::int32_t v[kLanes],
                              float out[kLanes]) const {
  const std::int32_t bits = kBits - level, mask = (1 << bits) - 1;
  const std::uint32_t* const quads = quads_.data() + offset_[level];
  std::int32_t x[kLanes], y[kLanes], at[kLanes];
  std::uint32_t quad[kLanes];
  for (int k = 0; k < kLanes; ++k) {
    // Texel i of level 0 is centred at i; a texel of level n stands for 2^n of them.
    x[k] = ((u[k] + 128) >> level) - 128;
    y[k] = ((v[k] + 128) >> level) - 128;
    at[k] = indexOf(bits, (x[k] >> 8) & mask, (y[k] >> 8) & mask);
  }
  for (int k = 0; k < kLanes; ++k) quad[k] = quads[at[k]];
  for (int k = 0; k < kLanes; ++k) {
    const auto part = [&](int shift) {
      return static_cast<float>(static_cast<std::int32_t>(quad[k] >> shift & 255U));
    };
    const auto a = static_cast<float>(x[k] & 255), b = static_cast<float>(y[k] & 255);
    const float upper = part(0) * (256 - a) + part(8) * a;
    const float lower = part(16) * (256 - a) + part(24) * a;
    out[k] = upper * (256 - b) + lower * b;
  }
}

inline void Texture::look(const Sampling& s, const float u[kLanes], const float v[kLanes],
                          float out[kLanes]) const {
  constexpr float kScale = 1.0F / 65536.0F;
  std::int32_t at_u[kLanes], at_v[kLanes];
  for (int k = 0; k < kLanes; ++k) {
    const Place at = placeOf(u[k], v[k]);
    at_u[k] = at.u - s.step.u * (s.probes - 1) / 2;
    at_v[k] = at.v - s.step.v * (s.probes - 1) / 2;
  }
  float sum[kLanes] = {};
  for (int p = 0; p < s.probes; ++p) {
    float fine[kLanes];
    bilinear(s.level, at_u, at_v, fine);
    for (int k = 0; k < kLanes; ++k) sum[k] += fine[k];
    if (s.coarse > 0) {
      float coarse[kLanes];
      bilinear(s.level + 1, at_u, at_v, coarse);
      for (int k = 0; k < kLanes; ++k) sum[k] += s.coarse * (coarse[k] - fine[k]);
    }
    for (int k = 0; k < kLanes; ++k) {
      at_u[k] += s.step.u;
      at_v[k] += s.step.v;
    }
  }
  for (int k = 0; k < kLanes; ++k) {
    out[k] = kScale * sum[k] / static_cast<float>(s.probes) - 128.0F;
  }
}

}  // namespace vir::rendering
