#pragma once
/// Images as a real camera would take them of a scene: exposure, blur, vignetting, noise.
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "vir/core/options.h"
#include "vir/core/time.h"
#include "vir/rendering/scene_renderer.h"

namespace vir::rendering {

struct CameraSimulationOptions {
  double noise_grey = 1.5;    ///< white, per pixel, in the dark
  double shot_noise = 0.03;   ///< variance that comes with the light, per grey level
  double vignetting = 0.3;    ///< light lost in the image's corners
  double exposure_s = 0.003;  ///< how long the shutter is open: motion blur; 0 = no blur
  double blur_step_px = 1.5;  ///< motion within one of the sharp images that make a blurred one
  int max_blur_steps = 10;
  /// Rolling shutter: time from the first row to the last; each row's exposure is centred on its
  /// own time, the middle row's on the image's. 0 = all rows at once.
  double readout_s = 0;
  double exposure_wander = 0.08;      ///< brightness wanders by this share (standard deviation)
  std::vector<double> exposure_jump;  ///< time [s], gain, time, gain ...: brightness from then on
  std::vector<double> dark_s;         ///< from to, from to ...: hardly any light
  double dark_gain = 0.01;
  std::vector<double> poor_texture_s;  ///< from to ...: plain walls
  double poor_contrast = 0.04;
  int seed = 1;
};
/// Section [SimulatedCamera].
void describe(OptionVisitor& v, CameraSimulationOptions& o);

struct GrayImage {
  int width = 0, height = 0;
  std::vector<std::uint8_t> pixels;  ///< row by row
};

class CameraSimulator {
 public:
  /// Pose T_W_C of the camera `dt` seconds after the middle of the exposure.
  using PoseAt = std::function<Pose(double dt)>;

  /// Cameras with the same `surface_seed` see the same surfaces. Throws std::invalid_argument for
  /// lists of the wrong length.
  CameraSimulator(const CameraSimulationOptions& options, std::shared_ptr<const Scene> scene,
                  std::shared_ptr<const camera::CameraModel> camera, int surface_seed = 1);
  ~CameraSimulator();

  /// The image whose exposure (of the middle row) is centred `since_begin_s` after the recording's
  /// begin. A function of its arguments and the settings alone; `number` (of the image) chooses the
  /// noise. The result holds until the next call.
  const GrayImage& take(double since_begin_s, std::uint64_t number, const PoseAt& T_W_C);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace vir::rendering
