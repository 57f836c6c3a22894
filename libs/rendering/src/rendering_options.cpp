#include "vir/rendering/camera_simulator.h"
#include "vir/rendering/make_scene.h"

namespace vir::rendering {
namespace {

constexpr Bounds<double> kShare{0.0, 1.0};
constexpr Bounds<double> kNotNegative{0.0, 1e6};
constexpr Bounds<double> kMetres{0.05, 1000.0};
constexpr Bounds<int> kSeed{0, 2000000000};

}  // namespace

void describe(OptionVisitor& v, SceneOptions& o) {
  v.section("Scene", "The place the robots are in: a room with boxes");
  v.choice("layout", o.layout, {"room", "corridors"},
           "one hall, or solid up to the ceiling except near the paths");
  v.value("margin_m", o.margin_m, kMetres, "the room reaches this far beyond the paths");
  v.value("below_m", o.below_m, kMetres, "floor below the lowest pose");
  v.value("above_m", o.above_m, kMetres, "ceiling above the highest pose");
  v.value("corridor_half_width_m", o.corridor_half_width_m, kMetres,
          "solid is what is farther from the paths");
  v.value("clearance_m", o.clearance_m, kMetres, "nothing stands nearer to a path");
  v.value("boxes", o.boxes, {0, 2000}, "crates, cabinets, pillars and beams");
  v.value("seed", o.seed, kSeed, "of boxes and surfaces");
}

void describe(OptionVisitor& v, CameraSimulationOptions& o) {
  v.section("SimulatedCamera", "What the simulated camera does to its images");
  v.value("noise_grey", o.noise_grey, {0.0, 255.0}, "white noise per pixel in the dark");
  v.value("shot_noise", o.shot_noise, kShare, "variance that comes with the light, per grey level");
  v.value("vignetting", o.vignetting, kShare, "share of the light lost in the corners");
  v.value("exposure_s", o.exposure_s, kShare, "shutter time: motion blur; 0 = none");
  v.value("blur_step_px", o.blur_step_px, {0.05, 100.0},
          "motion covered by one of the sharp images a blurred one is made of");
  v.value("max_blur_steps", o.max_blur_steps, {1, 100}, "most sharp images in a blurred one");
  v.value("exposure_wander", o.exposure_wander, kShare,
          "brightness wanders by this share (standard deviation)");
  v.value("exposure_jump", o.exposure_jump, 0,
          "time [s] gain, time gain ...: brightness from then");
  v.value("dark_s", o.dark_s, 0, "from to, from to ...: hardly any light");
  v.value("dark_gain", o.dark_gain, kNotNegative, "brightness then");
  v.value("poor_texture_s", o.poor_texture_s, 0, "from to, from to ...: plain walls");
  v.value("poor_contrast", o.poor_contrast, kShare, "contrast of the textures then");
  v.value("seed", o.seed, kSeed, "of noise and brightness");
}

}  // namespace vir::rendering
