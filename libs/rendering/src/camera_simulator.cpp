#include "vir/rendering/camera_simulator.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "vir/core/angles.h"
#include "vir/core/random.h"

namespace vir::rendering {
namespace {

/// How far away the things are whose motion blur counts [m].
constexpr double kBlurDistance_m = 2;
constexpr int kWaves = 4;
/// Rows of a rolling shutter that are drawn from one place: at 2 rad/s and 20 ms a fifth of a
/// pixel.
constexpr int kBand = 8;

bool inside(const std::vector<double>& stretches, double s) {
  for (std::size_t k = 0; k + 1 < stretches.size(); k += 2) {
    if (s >= stretches[k] && s < stretches[k + 1]) return true;
  }
  return false;
}

void checkPairs(const char* key, const std::vector<double>& values) {
  if (values.size() % 2 == 0) return;
  throw std::invalid_argument(std::string("CameraSimulator: ") + key +
                              " must hold pairs; there are " + std::to_string(values.size()) +
                              " values");
}

/// Nearly Gaussian with standard deviation 1: the sum of the four 16-bit parts of a mixed number.
float smallNormal(std::uint64_t x) {
  const std::uint64_t bits = mixBits(x);
  const auto sum = static_cast<std::int64_t>((bits & 0xFFFF) + ((bits >> 16) & 0xFFFF) +
                                             ((bits >> 32) & 0xFFFF) + (bits >> 48));
  // Four uniforms of width 65536: variance 4 * 65536^2 / 12.
  constexpr float kScale = 1.0F / 37837.2F;
  return static_cast<float>(sum - 131070) * kScale;
}

}  // namespace

struct CameraSimulator::Impl {
  Impl(const CameraSimulationOptions& o, std::shared_ptr<const Scene> scene,
       const std::shared_ptr<const camera::CameraModel>& camera, int surface_seed)
      : options(o), renderer(std::move(scene), camera, surface_seed) {
    const CameraCalibration& c = camera->calibration();
    image.width = light.width = c.width;
    image.height = light.height = c.height;
    const std::size_t n = static_cast<std::size_t>(c.width) * static_cast<std::size_t>(c.height);
    image.pixels.assign(n, 0);
    light.pixels.assign(n, 0.0F);
    makeVignetting(c);
    Random random(static_cast<std::uint64_t>(o.seed), 530);
    for (int k = 0; k < kWaves; ++k) {
      omega[k] = 2 * kPi * random.uniform(0.03, 0.4);
      phase[k] = random.uniform(0, 2 * kPi);
    }
  }

  void makeVignetting(const CameraCalibration& c) {
    const double corner = 0.25 * (1.0 * c.width * c.width + 1.0 * c.height * c.height);
    for (int y = 0; y < c.height; ++y) {
      for (int x = 0; x < c.width; ++x) {
        const double dx = x + 0.5 - 0.5 * c.width, dy = y + 0.5 - 0.5 * c.height;
        vignetting.push_back(
            static_cast<float>(1 - options.vignetting * (dx * dx + dy * dy) / corner));
      }
    }
  }

  double gain(double s) const {
    double wave = 0;
    for (int k = 0; k < kWaves; ++k) wave += std::sin(omega[k] * s + phase[k]);
    double g = std::exp(options.exposure_wander * wave * std::sqrt(2.0 / kWaves));
    double jump = 1;
    for (std::size_t k = 0; k + 1 < options.exposure_jump.size(); k += 2) {
      if (s >= options.exposure_jump[k]) jump = options.exposure_jump[k + 1];
    }
    if (inside(options.dark_s, s)) g *= options.dark_gain;
    return g * jump;
  }

  int blurSteps(const PoseAt& T_W_C) const;
  void expose(double s, const PoseAt& T_W_C);
  void exposeRows(int from_row, int to_row, int steps, double contrast, double row_s,
                  const PoseAt& T_W_C);
  void readOut(float gain, std::uint64_t number);

  CameraSimulationOptions options;
  SceneRenderer renderer;
  std::vector<float> vignetting;
  double omega[kWaves] = {}, phase[kWaves] = {};
  FloatImage light;
  GrayImage image;
};

int CameraSimulator::Impl::blurSteps(const PoseAt& T_W_C) const {
  if (options.exposure_s <= 0) return 1;
  const Pose first = T_W_C(-0.5 * options.exposure_s), last = T_W_C(0.5 * options.exposure_s);
  const CameraCalibration& c = renderer.camera().calibration();
  const double turn = logQuat(first.q.conjugate() * last.q).norm();
  const double moved = (last.p - first.p).norm() / kBlurDistance_m;
  const double px = std::max(c.fx, c.fy) * (turn + moved);
  const double steps = std::ceil(px / std::max(0.05, options.blur_step_px));
  return static_cast<int>(std::clamp(steps, 1.0, 1.0 * std::max(1, options.max_blur_steps)));
}

void CameraSimulator::Impl::expose(double s, const PoseAt& T_W_C) {
  std::fill(light.pixels.begin(), light.pixels.end(), 0.0F);
  const double contrast = inside(options.poor_texture_s, s) ? options.poor_contrast : 1.0;
  const int steps = blurSteps(T_W_C);
  if (options.readout_s <= 0) {
    exposeRows(0, light.height, steps, contrast, 0, T_W_C);
    return;
  }
  for (int row = 0; row < light.height; row += kBand) {
    const int to = std::min(light.height, row + kBand);
    const double share = 0.5 * (row + to - 1) / light.height - 0.5;
    exposeRows(row, to, steps, contrast, share * options.readout_s, T_W_C);
  }
}

void CameraSimulator::Impl::exposeRows(int from_row, int to_row, int steps, double contrast,
                                       double row_s, const PoseAt& T_W_C) {
  for (int k = 0; k < steps; ++k) {
    const double dt = row_s + options.exposure_s * ((k + 0.5) / steps - 0.5);
    renderer.addRows(T_W_C(dt), from_row, to_row, contrast, 1.0F / static_cast<float>(steps),
                     &light);
  }
}

void CameraSimulator::Impl::readOut(float gain, std::uint64_t number) {
  const auto read2 = static_cast<float>(options.noise_grey * options.noise_grey);
  const auto shot = static_cast<float>(options.shot_noise);
  const std::uint64_t salt =
      mixBits(mixBits(static_cast<std::uint64_t>(options.seed) + 540) + number);
  for (std::size_t k = 0; k < image.pixels.size(); ++k) {
    const float grey = gain * vignetting[k] * light.pixels[k];
    const float noise = std::sqrt(read2 + shot * grey) * smallNormal(salt + k);
    const float value = std::min(std::max(grey + noise + 0.5F, 0.0F), 255.0F);
    image.pixels[k] = static_cast<std::uint8_t>(value);
  }
}

CameraSimulator::CameraSimulator(const CameraSimulationOptions& o,
                                 std::shared_ptr<const Scene> scene,
                                 std::shared_ptr<const camera::CameraModel> camera,
                                 int surface_seed) {
  checkPairs("exposure_jump", o.exposure_jump);
  checkPairs("dark_s", o.dark_s);
  checkPairs("poor_texture_s", o.poor_texture_s);
  if (!scene || !camera) throw std::invalid_argument("CameraSimulator: no scene or no camera");
  impl_ = std::make_unique<Impl>(o, std::move(scene), camera, surface_seed);
}
CameraSimulator::~CameraSimulator() = default;

const GrayImage& CameraSimulator::take(double since_begin_s, std::uint64_t number,
                                       const PoseAt& T_W_C) {
  impl_->expose(since_begin_s, T_W_C);
  impl_->readOut(static_cast<float>(impl_->gain(since_begin_s)), number);
  return impl_->image;
}

}  // namespace vir::rendering
