#pragma once
/// A camera's view of a scene by ray casting: textures without aliasing, smooth edges, no memory
/// taken per image.
#include <memory>
#include <vector>

#include "vir/camera/camera_model.h"
#include "vir/geometry/pose.h"
#include "vir/rendering/scene.h"

namespace vir::rendering {

/// Radiance in grey levels: 0 black, 255 white at an exposure gain of 1.
struct FloatImage {
  int width = 0, height = 0;
  std::vector<float> pixels;  ///< row by row

  float at(int x, int y) const { return pixels[static_cast<std::size_t>(y * width + x)]; }
};

class SceneRenderer {
 public:
  /// `seed` makes the surfaces. Throws std::invalid_argument without scene or camera.
  SceneRenderer(std::shared_ptr<const Scene> scene,
                std::shared_ptr<const camera::CameraModel> camera, int seed);
  ~SceneRenderer();

  /// Adds `weight` times the view from T_W_C to `sum` (made black and of the camera's size if it
  /// has another). `contrast` 1: surfaces as they are, 0: plain ones. Pixels that no ray belongs to
  /// and rays from outside the room see black. Not for two threads at a time.
  void add(const Pose& T_W_C, double contrast, float weight, FloatImage* sum);
  /// The same for the rows from `from_row` to before `to_row` alone.
  void addRows(const Pose& T_W_C, int from_row, int to_row, double contrast, float weight,
               FloatImage* sum);
  /// As on a processor without wide vectors: the same image, slower.
  void useNarrowVectors();

  const camera::CameraModel& camera() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace vir::rendering
