#include "surfaces.h"

#include <algorithm>
#include <cmath>

#include "vir/core/random.h"

namespace vir::rendering {

namespace {

/// Texels per metre of the fine layer: about a pixel at 1 m.
constexpr double kFinePerM = 350;
/// The coarse layer's are this much larger, no whole number.
constexpr double kCoarser = 4.7;

/// Draws for boxes that look alike come from here on, one stream per look.
constexpr std::uint64_t kLookStream = 100000;

const TextureStyle kStyles[] = {
    {4.0, 150, 0.5, 1.0, 0.3},  // patches of all kinds
    {5.0, 220, 0.1, 0.2, 0.2},  // mostly upright rectangles
    {9.0, 250, 0.3, 0.6, 0.5},  // large patches
    {3.0, 60, 0.6, 1.0, 0.2},   // small ones
};

}  // namespace

Surfaces::Surfaces(const Scene& scene, int seed) {
  const auto s = static_cast<std::uint64_t>(seed);
  std::uint64_t stream = 520;
  for (const TextureStyle& style : kStyles) {
    textures_.push_back(std::make_shared<Texture>(style, s, stream++));
  }
  Random random(s, 510);
  for (int axis = 0; axis < 3; ++axis) addFaces(scene.interior(), axis, &random);
  for (const Box& b : scene.boxes()) {
    Random alike(s, kLookStream + static_cast<std::uint64_t>(std::max(b.look, 0)));
    Random* const from = b.look < 0 ? &random : &alike;
    for (int axis = 0; axis < 3; ++axis) addFaces(b, axis, from);
  }
  const Vec3 size = scene.interior().high - scene.interior().low;
  lamp_ = scene.interior().low + 0.5 * size;
  lamp_ += Vec3(0.1 * size.x(), -0.07 * size.y(), 0);
  lamp_.z() = scene.interior().high.z() - std::min(0.3, 0.1 * size.z());
  const double reach = 0.6 * size.norm();
  fall_off_ = static_cast<float>(1 / (reach * reach));
}

void Surfaces::addFaces(const Box& box, int axis, Random* random) {
  Vec3 size = box.high - box.low;
  size[axis] = 0;
  for (int side = 0; side < 2; ++side) {
    Face f = drawFace(size.maxCoeff(), random);
    if (box.look >= 0) fixTo(box.low, axis, &f);
    faces_.push_back(f);
  }
}

Surfaces::Face Surfaces::drawFace(double size_m, Random* random) const {
  const auto any = [&] {
    return static_cast<int>(random->uniform() * static_cast<double>(textures_.size()));
  };
  Face f;
  f.base = static_cast<float>(random->uniform(80, 160));
  // Some surfaces have little on them, as walls do.
  const double strength = random->uniform() < 0.25 ? 0.12 : random->uniform(0.3, 0.9);
  const double any_share = random->uniform(0.35, 0.65);
  const double share = size_m * kFinePerM < Texture::kSize ? 1 : any_share;
  for (Layer* layer : {&f.fine, &f.coarse}) {
    const bool fine = layer == &f.fine;
    layer->texture = any();
    layer->per_m = static_cast<float>(fine ? kFinePerM : kFinePerM / kCoarser);
    layer->log2_per_m = std::log2(layer->per_m);
    layer->u = static_cast<float>(random->uniform(0, Texture::kSize));
    layer->v = static_cast<float>(random->uniform(0, Texture::kSize));
    layer->gain = static_cast<float>(strength * (fine ? share : 1 - share));
  }
  return f;
}

/// The textures begin at a corner of the box instead of W's origin.
void Surfaces::fixTo(const Vec3& corner, int axis, Face* face) {
  for (Layer* layer : {&face->fine, &face->coarse}) {
    layer->u -= layer->per_m * static_cast<float>(corner[(axis + 1) % 3]);
    layer->v -= layer->per_m * static_cast<float>(corner[(axis + 2) % 3]);
  }
}

void Surfaces::lookFrom(const Vec3& eye) {
  for (int k = 0; k < 3; ++k) lamp_relative_[k] = static_cast<float>(lamp_[k] - eye[k]);
  for (std::size_t k = 0; k < faces_.size(); ++k) {
    const int axis = static_cast<int>(k % kFacesPerBox) / 2;
    const double u = eye[(axis + 1) % 3], v = eye[(axis + 2) % 3];
    for (Layer* layer : {&faces_[k].fine, &faces_[k].coarse}) {
      // Whole turns of the texture are taken off: floats are precise near zero.
      const double size = Texture::kSize;
      layer->eye_u = static_cast<float>(std::remainder(layer->u + u * layer->per_m, size));
      layer->eye_v = static_cast<float>(std::remainder(layer->v + v * layer->per_m, size));
    }
  }
}

}  // namespace vir::rendering
