#pragma once
/// A made-up surface: a square that repeats without a seam, at every scale it may be looked at.
#include <cstdint>
#include <vector>

#include "lanes.h"

namespace vir::rendering {

struct TextureStyle {
  double smallest = 4, largest = 180;  ///< radii of its patches [texels]
  double round = 0.5;                  ///< share of discs; the others are rectangles
  double tilted = 1;                   ///< share of the rectangles that are turned
  double gradient = 0.3;               ///< brightness changes this much within a patch
};

/// A pixel that is longer than wide on the surface is looked at in several places.
constexpr float kMaxProbes = 3;
/// Below 1: somewhat too blurred along the footprint rather than aliased.
constexpr float kProbesPerRatio = 0.6F;

/// How the areas of several pixels lie on their surfaces; one of them may stand for its neighbours.
struct Footprints {
  Floats length, log2_length;  ///< [m]
  Floats ratio;                ///< of length and width, within what is made use of
  Floats du, dv;               ///< its length as a vector [m]
};

/// From the change of the position on the surface from a pixel to the next, right and down [m].
Footprints footprintsOf(Floats du_dx, Floats dv_dx, Floats du_dy, Floats dv_dy);

/// Patches that cover each other, sizes by an inverse cube law: the statistics of natural images
/// ("dead leaves", Lee, Mumford and Huang, IJCV 2001). With it go all halvings of its resolution.
class Texture {
 public:
  static constexpr int kBits = 10;
  static constexpr int kSize = 1 << kBits;
  static constexpr int kLevels = 9;

  Texture(const TextureStyle& style, std::uint64_t seed, std::uint64_t stream);

  /// How a pixel's area is looked at. Steps are positions in integers: texels of the finest level,
  /// 8 bits of fraction.
  struct Sampling {
    int level, probes;
    float coarse;        ///< share of the next level
    int step_u, step_v;  ///< from probe to probe
  };
  struct Samplings {
    Ints level, probes;
    Floats coarse;
    Ints step_u, step_v;
    Sampling of(int lane) const {
      return {level[lane], probes[lane], coarse[lane], step_u[lane], step_v[lane]};
    }
  };
  static Samplings samplingsOf(const Footprints& f, Floats texels_per_m, Floats log2_texels_per_m);
  /// Grey levels about 0 (-128..127) at positions [texels]. Continuous but for the number of
  /// probes.
  Floats look(const Sampling& s, Floats u, Floats v) const;

 private:
  /// Of a quad within its level of 2^bits by 2^bits: squares of 4 by 4 lie together, so that a
  /// small piece of a surface is near in memory whichever way it is turned.
  template <typename T>
  static T indexOf(std::int32_t bits, T x, T y) {
    return ((y >> 2) << (bits + 2)) | ((x >> 2) << 4) | ((y & 3) << 2) | (x & 3);
  }
  /// Of integer positions, within the level.
  static Ints indicesOf(int level, Ints u, Ints v) {
    const std::int32_t bits = kBits - level, mask = (1 << bits) - 1;
    return indexOf(bits, (u >> 8) & mask, (v >> 8) & mask);
  }
  /// Texel i of level 0 is centred at i; a texel of level n stands for 2^n of them.
  static Ints onLevel(int level, Ints u) { return ((u + 128) >> level) - 128; }
  /// 0 .. 255 * 65536: as floats still exact.
  Floats bilinear(int level, Ints u, Ints v) const;
  /// Each holds a texel, its right neighbour, the one below it and that one's right neighbour, a
  /// byte each from the lowest: what bilinear interpolation needs in one access. All levels, the
  /// finest first.
  std::vector<std::uint32_t> quads_;
  std::int32_t offset_[kLevels] = {};
};

inline Footprints footprintsOf(Floats du_dx, Floats dv_dx, Floats du_dy, Floats dv_dy) {
  const Floats xx = du_dx * du_dx + dv_dx * dv_dx, yy = du_dy * du_dy + dv_dy * dv_dy;
  const Ints along_x = xx > yy;
  const Floats long2 = largest(along_x ? xx : yy, allOf(1e-12F));
  const Floats area = largest(magnitude(du_dx * dv_dy - du_dy * dv_dx), 1e-6F * long2);
  Footprints f;
  f.length = squareRoot(long2);
  f.log2_length = 0.5F * roughLog2(long2);
  f.ratio = clamped(kProbesPerRatio * long2 / area, allOf(1.0F), allOf(kMaxProbes));
  f.du = along_x ? du_dx : du_dy;
  f.dv = along_x ? dv_dx : dv_dy;
  return f;
}

inline Texture::Samplings Texture::samplingsOf(const Footprints& f, Floats texels_per_m,
                                               Floats log2_texels_per_m) {
  Samplings s;
  // Probes nearer to each other than a texel tell nothing new.
  const Floats ratio = clamped(f.length * texels_per_m, allOf(1.0F), f.ratio);
  static_assert(kMaxProbes == 3);
  // The next whole number: true is -1.
  s.probes = 1 - (ratio > 1) - (ratio > 2);
  const Floats step = texels_per_m / toFloats(s.probes);
  s.step_u = toInts(step * f.du * 256.0F);
  s.step_v = toInts(step * f.dv * 256.0F);
  // A whole number of probes would show as a line on the floor where it changes: the level is taken
  // from the ratio.
  const Floats most = allOf(static_cast<float>(kLevels) - 1.001F);
  const Floats l = clamped(f.log2_length + log2_texels_per_m - roughLog2(ratio), Floats{}, most);
  s.level = toInts(l);
  // Pure levels for half of the way, mixed ones in between: half the work, and as smooth.
  s.coarse = clamped(2 * (l - toFloats(s.level)) - 0.5F, Floats{}, allOf(1.0F));
  const Ints next = s.coarse >= 1;
  s.level -= next;
  s.coarse = next ? Floats{} : s.coarse;
  return s;
}

inline Floats Texture::bilinear(int level, Ints u, Ints v) const {
  const std::uint32_t* const quads = quads_.data() + offset_[level];
  const Ints x = onLevel(level, u), y = onLevel(level, v);
  const Ints at = indicesOf(level, x, y);
  Ints quad{};
  for (int k = 0; k < kLanes; ++k) quad[k] = static_cast<std::int32_t>(quads[at[k]]);
  const auto part = [&](int shift) { return toFloats((quad >> shift) & 255); };
  const Floats a = toFloats(x & 255), b = toFloats(y & 255);
  const Floats upper = part(0) * (256 - a) + part(8) * a;
  const Floats lower = part(16) * (256 - a) + part(24) * a;
  return upper * (256 - b) + lower * b;
}

inline Floats Texture::look(const Sampling& s, Floats u, Floats v) const {
  constexpr float kScale = 1.0F / 65536.0F;
  Ints at_u = toInts(u * 256.0F) - s.step_u * (s.probes - 1) / 2;
  Ints at_v = toInts(v * 256.0F) - s.step_v * (s.probes - 1) / 2;
  Floats sum{};
  for (int p = 0; p < s.probes; ++p) {
    const Floats fine = bilinear(s.level, at_u, at_v);
    sum += fine;
    if (s.coarse > 0) sum += s.coarse * (bilinear(s.level + 1, at_u, at_v) - fine);
    at_u += s.step_u;
    at_v += s.step_v;
  }
  return kScale * sum / static_cast<float>(s.probes) - 128.0F;
}

}  // namespace vir::rendering
