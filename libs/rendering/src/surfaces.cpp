#include "surfaces.h"

#include <algorithm>
#include <cmath>

#include "vir/core/random.h"

namespace vir::rendering {

inline void Surfaces::addLook(const Layer& l, const Texture::Sampling& sampling,
                              const float u[kLanes], const float v[kLanes],
                              float sum[kLanes]) const {
  const Texture& t = *textures_[static_cast<std::size_t>(l.texture)];
  float at_u[kLanes], at_v[kLanes], grey[kLanes];
  for (int k = 0; k < kLanes; ++k) {
    at_u[k] = l.eye_u + u[k] * l.per_m;
    at_v[k] = l.eye_v + v[k] * l.per_m;
  }
  t.look(sampling, at_u, at_v, grey);
  for (int k = 0; k < kLanes; ++k) sum[k] += l.gain * grey[k];
}

namespace {

/// Texels per metre of the fine layer: about a pixel at 1 m.
constexpr double kFinePerM = 350;
/// The coarse layer's are this much larger, no whole number.
constexpr double kCoarser = 4.7;
/// Light that comes from everywhere, and from the lamp.
constexpr float kAmbient = 0.55F, kDiffuse = 0.5F;

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

FaceView Surfaces::view(int face, const float d[3], float t, const float dx[3],
                        const float dy[3]) const {
  FaceView w;
  w.face = face;
  w.axis = (face % kFacesPerBox) / 2;
  w.u = (w.axis + 1) % 3;
  w.v = (w.axis + 2) % 3;
  // Where the next pixel's ray meets the plane of the face.
  const float turn_x = dx[w.axis] / d[w.axis], turn_y = dy[w.axis] / d[w.axis];
  const Footprint f = footprintOf(t * (dx[w.u] - d[w.u] * turn_x), t * (dx[w.v] - d[w.v] * turn_x),
                                  t * (dy[w.u] - d[w.u] * turn_y), t * (dy[w.v] - d[w.v] * turn_y));
  const Face& at = faces_[static_cast<std::size_t>(face)];
  w.fine = Texture::samplingOf(f, at.fine.per_m, at.fine.log2_per_m);
  w.coarse = Texture::samplingOf(f, at.coarse.per_m, at.coarse.log2_per_m);
  return w;
}

void Surfaces::radiance(const FaceView& w, const float relative[3][kLanes], float contrast,
                        float out[kLanes]) const {
  const Face& f = faces_[static_cast<std::size_t>(w.face)];
  float texture[kLanes] = {};
  addLook(f.fine, w.fine, relative[w.u], relative[w.v], texture);
  if (f.coarse.gain > 0) addLook(f.coarse, w.coarse, relative[w.u], relative[w.v], texture);
  // The room's walls look inwards: to the other side than a box's.
  const bool up = (w.face % 2 == 1) != (w.face < kFacesPerBox);
  const float side = up ? 1.0F : -1.0F;
  for (int k = 0; k < kLanes; ++k) {
    const float albedo = f.base + contrast * texture[k];
    const float x = lamp_relative_[0] - relative[0][k], y = lamp_relative_[1] - relative[1][k],
                z = lamp_relative_[2] - relative[2][k];
    const float square = x * x + y * y + z * z + 1e-6F;
    const float ahead = lamp_relative_[w.axis] - relative[w.axis][k];
    const float facing = side * ahead / std::sqrt(square);
    const float light = kAmbient + kDiffuse * std::max(facing, 0.0F) / (1 + square * fall_off_);
    out[k] = std::max(albedo * light, 2.0F);
  }
}

}  // namespace vir::rendering
