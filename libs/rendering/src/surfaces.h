#pragma once
/// What the faces of a scene look like: textures, brightness, light.
#include <cstdint>
#include <memory>
#include <vector>

#include "texture.h"
#include "vir/core/random.h"
#include "vir/rendering/scene.h"

namespace vir::rendering {

/// Face 2 * axis of a box looks to the lower side, 2 * axis + 1 to the upper; the room comes first,
/// box k after it. Seen from inside the room's faces are the same: 2 * axis is its lower wall.
constexpr int kFacesPerBox = 6;
/// Light that comes from everywhere, and from the lamp.
constexpr float kAmbient = 0.55F, kDiffuse = 0.5F;

/// How one face is seen in one part of the image. The face's axes u and v are the two after its
/// normal.
struct FaceView {
  int face, axis, u, v;
  Texture::Sampling fine, coarse;
};

class Surfaces {
 public:
  Surfaces(const Scene& scene, int seed);
  /// The camera is at `eye`.
  void lookFrom(const Vec3& eye);
  /// Rays of directions `d` (all x, all y, all z) meet faces at distances `t`; from a pixel to the
  /// next they change by `dx` and `dy`.
  void views(const int face[kLanes], const Floats d[3], Floats t, const float dx[3],
             const float dy[3], FaceView out[kLanes]) const;
  /// Grey levels of points of that face, `relative` to the camera, in W [m]: all x, all y, all z.
  /// `contrast` of the textures, 1 = as made.
  Floats radiance(const FaceView& view, const Floats relative[3], float contrast) const;

 private:
  /// On large faces two textures of different scale lie on each other: together they do not repeat.
  struct Layer {
    int texture = 0;
    float per_m = 0, log2_per_m = 0;  ///< texels
    float u = 0, v = 0;
    float gain = 0;
    float eye_u = 0, eye_v = 0;  ///< of the camera's place [texels]
  };
  struct Face {
    float base = 0;  ///< grey level
    Layer fine, coarse;
  };
  /// Of both sides across `axis`.
  void addFaces(const Box& box, int axis, Random* random);
  static void fixTo(const Vec3& corner, int axis, Face* face);
  Face drawFace(double size_m, Random* random) const;
  Floats look(const Layer& layer, const Texture::Sampling& sampling, Floats u, Floats v) const;

  std::vector<std::shared_ptr<const Texture>> textures_;
  std::vector<Face> faces_;
  Vec3 lamp_ = Vec3::Zero();
  float lamp_relative_[3] = {0, 0, 0};
  float fall_off_ = 0;  ///< [1/m^2]
};

inline Floats Surfaces::look(const Layer& l, const Texture::Sampling& sampling, Floats u,
                             Floats v) const {
  const Texture& t = *textures_[static_cast<std::size_t>(l.texture)];
  return l.gain * t.look(sampling, l.eye_u + u * l.per_m, l.eye_v + v * l.per_m);
}

inline void Surfaces::views(const int face[kLanes], const Floats d[3], Floats t, const float dx[3],
                            const float dy[3], FaceView out[kLanes]) const {
  // Along a face's normal, its u and its v; of its layers, the fine one first.
  float rays[3][kLanes], rights[3][kLanes], downs[3][kLanes];
  float per_m[2][kLanes], log2_per_m[2][kLanes];
  for (int k = 0; k < kLanes; ++k) {
    FaceView& w = out[k];
    w.face = face[k];
    w.axis = (w.face % kFacesPerBox) / 2;
    w.u = (w.axis + 1) % 3;
    w.v = (w.axis + 2) % 3;
    const int axes[3] = {w.axis, w.u, w.v};
    for (int a = 0; a < 3; ++a) {
      rays[a][k] = d[axes[a]][k];
      rights[a][k] = dx[axes[a]];
      downs[a][k] = dy[axes[a]];
    }
    const Face& at = faces_[static_cast<std::size_t>(w.face)];
    per_m[0][k] = at.fine.per_m;
    per_m[1][k] = at.coarse.per_m;
    log2_per_m[0][k] = at.fine.log2_per_m;
    log2_per_m[1][k] = at.coarse.log2_per_m;
  }
  const Floats ray[3] = {loaded(rays[0]), loaded(rays[1]), loaded(rays[2])};
  const Floats right[3] = {loaded(rights[0]), loaded(rights[1]), loaded(rights[2])};
  const Floats down[3] = {loaded(downs[0]), loaded(downs[1]), loaded(downs[2])};
  // Where the next pixel's ray meets the plane of the face.
  const Floats turn_x = right[0] / ray[0], turn_y = down[0] / ray[0];
  const Footprints f =
      footprintsOf(t * (right[1] - ray[1] * turn_x), t * (right[2] - ray[2] * turn_x),
                   t * (down[1] - ray[1] * turn_y), t * (down[2] - ray[2] * turn_y));
  const Texture::Samplings fine = Texture::samplingsOf(f, loaded(per_m[0]), loaded(log2_per_m[0]));
  const Texture::Samplings coarse =
      Texture::samplingsOf(f, loaded(per_m[1]), loaded(log2_per_m[1]));
  for (int k = 0; k < kLanes; ++k) {
    out[k].fine = fine.of(k);
    out[k].coarse = coarse.of(k);
  }
}

inline Floats Surfaces::radiance(const FaceView& w, const Floats relative[3],
                                 float contrast) const {
  const Face& f = faces_[static_cast<std::size_t>(w.face)];
  Floats texture = look(f.fine, w.fine, relative[w.u], relative[w.v]);
  if (f.coarse.gain > 0) texture += look(f.coarse, w.coarse, relative[w.u], relative[w.v]);
  // The room's walls look inwards: to the other side than a box's.
  const bool up = (w.face % 2 == 1) != (w.face < kFacesPerBox);
  const float side = up ? 1.0F : -1.0F;
  const Floats albedo = f.base + contrast * texture;
  const Floats x = lamp_relative_[0] - relative[0], y = lamp_relative_[1] - relative[1],
               z = lamp_relative_[2] - relative[2];
  const Floats square = x * x + y * y + z * z + 1e-6F;
  const Floats ahead = lamp_relative_[w.axis] - relative[w.axis];
  const Floats facing = side * ahead / squareRoot(square);
  const Floats light = kAmbient + kDiffuse * largest(facing, Floats{}) / (1 + square * fall_off_);
  return largest(albedo * light, allOf(2.0F));
}

}  // namespace vir::rendering
