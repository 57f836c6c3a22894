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

/// How one face is seen in one part of the image. The face's axes u and v are the two after its
/// normal.
struct FaceView {
  int face = 0, axis = 0, u = 0, v = 0;
  Texture::Sampling fine, coarse;
};

class Surfaces {
 public:
  Surfaces(const Scene& scene, int seed);
  /// The camera is at `eye`.
  void lookFrom(const Vec3& eye);
  /// A ray of direction `d` meets the face at distance `t`; from a pixel to the next it changes by
  /// `dx` and `dy`.
  FaceView view(int face, const float d[3], float t, const float dx[3], const float dy[3]) const;
  static constexpr int kLanes = Texture::kLanes;
  /// Grey levels of points of that face, `relative` to the camera, in W [m]: all x, all y, all z.
  /// `contrast` of the textures, 1 = as made.
  void radiance(const FaceView& view, const float relative[3][kLanes], float contrast,
                float out[kLanes]) const;

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
  void addLook(const Layer& layer, const Texture::Sampling& sampling, const float u[kLanes],
               const float v[kLanes], float sum[kLanes]) const;

  std::vector<std::shared_ptr<const Texture>> textures_;
  std::vector<Face> faces_;
  Vec3 lamp_ = Vec3::Zero();
  float lamp_relative_[3] = {0, 0, 0};
  float fall_off_ = 0;  ///< [1/m^2]
};

}  // namespace vir::rendering
