#include "texture.h"

#include <algorithm>
#include <cmath>

#include "vir/core/angles.h"
#include "vir/core/random.h"

namespace vir::rendering {
namespace {

/// The patches together have this many times the area of the texture.
constexpr double kCover = 4;

/// One patch of brightness.
struct Leaf {
  double x, y, half_u, half_v, c, s, grey, slope;
  bool round;

  /// Signed distance from the edge [texels], negative inside.
  double outside(double u, double v) const {
    if (round) return std::sqrt(u * u + v * v) - half_u;
    const double du = std::abs(u) - half_u, dv = std::abs(v) - half_v;
    return std::max(du, dv);
  }
};

Leaf drawLeaf(const TextureStyle& style, Random* random) {
  // Inverse of the cumulative distribution of r^-3 between the two radii.
  const double a = 1 / (style.smallest * style.smallest), b = 1 / (style.largest * style.largest);
  const double r = 1 / std::sqrt(a + random->uniform() * (b - a));
  Leaf leaf{};
  leaf.x = random->uniform(0, Texture::kSize);
  leaf.y = random->uniform(0, Texture::kSize);
  leaf.round = random->uniform() < style.round;
  const double aspect = random->uniform(0.35, 1);
  leaf.half_u = r;
  leaf.half_v = leaf.round ? r : aspect * r;
  const double turn = random->uniform(0, kPi);
  const double tilt = random->uniform() < style.tilted ? turn : (turn < kPi / 2 ? 0 : kPi / 2);
  leaf.c = std::cos(tilt);
  leaf.s = std::sin(tilt);
  leaf.grey = random->uniform(25, 230);
  leaf.slope = style.gradient * random->uniform(-60, 60) / r;
  return leaf;
}

void paintLeaf(const Leaf& leaf, std::uint8_t* out) {
  constexpr int kMask = Texture::kSize - 1;
  const double reach = std::hypot(leaf.half_u, leaf.round ? 0.0 : leaf.half_v) + 1;
  const int y0 = static_cast<int>(std::floor(leaf.y - reach));
  const int y1 = static_cast<int>(std::ceil(leaf.y + reach));
  const int x0 = static_cast<int>(std::floor(leaf.x - reach));
  const int x1 = static_cast<int>(std::ceil(leaf.x + reach));
  for (int y = y0; y <= y1; ++y) {
    std::uint8_t* row = out + (y & kMask) * Texture::kSize;
    for (int x = x0; x <= x1; ++x) {
      const double dx = x - leaf.x, dy = y - leaf.y;
      const double u = leaf.c * dx + leaf.s * dy, v = leaf.c * dy - leaf.s * dx;
      // A ramp of one texel instead of a step.
      const double cover = std::clamp(0.5 - leaf.outside(u, v), 0.0, 1.0);
      if (cover <= 0) continue;
      const double grey = std::clamp(leaf.grey + leaf.slope * u, 5.0, 250.0);
      std::uint8_t& texel = row[x & kMask];
      texel = static_cast<std::uint8_t>(texel + cover * (grey - texel) + 0.5);
    }
  }
}

std::vector<std::uint8_t> painted(const TextureStyle& style, std::uint64_t seed,
                                  std::uint64_t stream) {
  std::vector<std::uint8_t> texels(static_cast<std::size_t>(Texture::kSize * Texture::kSize), 128);
  Random random(seed, stream);
  double area = 0;
  while (area < kCover * Texture::kSize * Texture::kSize) {
    const Leaf leaf = drawLeaf(style, &random);
    paintLeaf(leaf, texels.data());
    area += leaf.round ? kPi * leaf.half_u * leaf.half_u : 4 * leaf.half_u * leaf.half_v;
  }
  // Grain, so that no patch is flat.
  for (std::uint8_t& texel : texels) {
    texel = static_cast<std::uint8_t>(std::clamp(texel + random.uniform(-5, 5), 0.0, 255.0));
  }
  return texels;
}

std::vector<std::uint8_t> halved(const std::vector<std::uint8_t>& texels, int size) {
  std::vector<std::uint8_t> out;
  for (int y = 0; y + 1 < size; y += 2) {
    for (int x = 0; x + 1 < size; x += 2) {
      const std::uint8_t* p = texels.data() + y * size + x;
      out.push_back(static_cast<std::uint8_t>((p[0] + p[1] + p[size] + p[size + 1] + 2) / 4));
    }
  }
  return out;
}

}  // namespace

Texture::Texture(const TextureStyle& style, std::uint64_t seed, std::uint64_t stream) {
  std::vector<std::uint8_t> texels = painted(style, seed, stream);
  for (int level = 0; level < kLevels; ++level) {
    const int size = kSize >> level, mask = size - 1;
    const std::size_t begin = quads_.size();
    offset_[level] = static_cast<std::int32_t>(begin);
    quads_.resize(begin + texels.size());
    for (int y = 0; y < size; ++y) {
      const std::uint8_t* top = texels.data() + y * size;
      const std::uint8_t* low = texels.data() + ((y + 1) & mask) * size;
      for (int x = 0; x < size; ++x) {
        const int next = (x + 1) & mask;
        const std::uint32_t upper = top[x] | static_cast<std::uint32_t>(top[next]) << 8;
        const std::uint32_t lower = low[x] | static_cast<std::uint32_t>(low[next]) << 8;
        quads_[begin + static_cast<std::size_t>(indexOf(kBits - level, x, y))] = upper | lower
                                                                                             << 16;
      }
    }
    texels = halved(texels, size);
  }
}

}  // namespace vir::rendering
