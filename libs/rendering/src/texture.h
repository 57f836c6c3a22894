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
  /// Grey level about 0 (-128..127). Continuous but for the number of probes.
  float look(const Sampling& s, Place at) const;

 private:
  /// Of a quad within its level of 2^bits by 2^bits: squares of 4 by 4 lie together, so that a
  /// small piece of a surface is near in memory whichever way it is turned.
  static std::int32_t indexOf(std::int32_t bits, std::int32_t x, std::int32_t y);
  /// 0 .. 255 * 65536.
  std::int32_t bilinear(int level, Place p) const;
  /// Each holds a texel, its right neighbour, the one below it and that one's right neighbour, a
  /// byte each from the lowest: what bilinear interpolation needs in one access. All levels, the
  /// finest first.
  std::vector<std::uint32_t> quads_;
  std::int32_t offset_[kLevels] = {};
};

inline std::int32_t Texture::indexOf(std::int32_t bits, std::int32_t x, std::int32_t y) {
  return ((y >> 2) << (bits + 2)) | ((x >> 2) << 4) | ((y & 3) << 2) | (x & 3);
}

inline std::int32_t Texture::bilinear(int level, Place p) const {
  const std::int32_t bits = kBits - level, mask = (1 << bits) - 1;
  // Texel i of level 0 is centred at i; a texel of level n stands for 2^n of them.
  const std::int32_t x = ((p.u + 128) >> level) - 128, y = ((p.v + 128) >> level) - 128;
  const std::uint32_t a = static_cast<std::uint32_t>(x & 255);
  const std::uint32_t b = static_cast<std::uint32_t>(y & 255);
  const std::int32_t at = offset_[level] + indexOf(bits, (x >> 8) & mask, (y >> 8) & mask);
  const std::uint32_t quad = quads_[static_cast<std::size_t>(at)];
  // Both rows at once, 16 bits each.
  const std::uint32_t left = quad & 0x00FF00FFU, right = (quad >> 8) & 0x00FF00FFU;
  const std::uint32_t rows = left * (256 - a) + right * a;
  return static_cast<std::int32_t>((rows & 0xFFFFU) * (256 - b) + (rows >> 16) * b);
}

inline float Texture::look(const Sampling& s, Place at) const {
  constexpr float kScale = 1.0F / 65536.0F;
  at.u -= s.step.u * (s.probes - 1) / 2;
  at.v -= s.step.v * (s.probes - 1) / 2;
  float sum = 0;
  for (int k = 0; k < s.probes; ++k) {
    const auto fine = static_cast<float>(bilinear(s.level, at));
    sum += fine;
    if (s.coarse > 0) {
      sum += s.coarse * (static_cast<float>(bilinear(s.level + 1, at)) - fine);
    }
    at.u += s.step.u;
    at.v += s.step.v;
  }
  return kScale * sum / static_cast<float>(s.probes) - 128.0F;
}

}  // namespace vir::rendering
