#include "rig.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace vir::simulator {
namespace {

/// The cameras' random numbers have seeds this far apart.
constexpr int kSeedsPerCamera = 100;

/// The begin of the stretch that holds `s`.
std::optional<double> beginOf(const std::vector<double>& stretches, double s) {
  for (std::size_t k = 0; k + 1 < stretches.size(); k += 2) {
    if (s >= stretches[k] && s < stretches[k + 1]) return stretches[k];
  }
  return std::nullopt;
}

void requirePairs(const char* key, const std::vector<double>& values) {
  if (values.size() % 2 == 0) return;
  throw std::invalid_argument(std::string("[Camera] ") + key + " must hold pairs; there are " +
                              std::to_string(values.size()) + " values");
}

}  // namespace

Rig::Rig(const SimulatorOptions& o) : effects_(o.camera_effects), surface_seed_(o.scene.seed) {
  std::vector<CameraOptions> all{o.camera};
  all.insert(all.end(), o.further_cameras.begin(), o.further_cameras.end());
  for (std::size_t k = 0; k < all.size(); ++k) {
    requirePairs("black_s", all[k].black_s);
    requirePairs("frozen_s", all[k].frozen_s);
    requirePairs("missing_s", all[k].missing_s);
    requirePairs("half_rate_s", all[k].half_rate_s);
    Camera c;
    c.options = all[k];
    c.calibration = calibrationOf(all[k]);
    c.T_B_C = mountOf(all[k]);
    const TrueCamera truth =
        trueCamera(all[k], effects_.seed + kSeedsPerCamera * static_cast<int>(k));
    c.model = camera::makeCamera(truth.calibration);
    c.true_T_B_C = truth.T_B_C;
    cameras_.push_back(std::move(c));
  }
}

void Rig::look(std::shared_ptr<const rendering::Scene> scene,
               std::shared_ptr<const simulation::Motion> motion) {
  motion_ = std::move(motion);
  for (std::size_t k = 0; k < cameras_.size(); ++k) {
    rendering::CameraSimulationOptions effects = effects_;
    effects.readout_s = cameras_[k].options.readout_s;
    effects.seed += kSeedsPerCamera * static_cast<int>(k);
    cameras_[k].simulator = std::make_unique<rendering::CameraSimulator>(
        effects, scene, cameras_[k].model, surface_seed_);
  }
}

std::vector<std::pair<TimeNs, std::uint64_t>> Rig::stamps(int camera) const {
  const CameraOptions& o = options(camera);
  const TimeNs offset = fromSeconds(o.trueOffset());
  std::vector<std::pair<TimeNs, std::uint64_t>> out;
  for (std::uint64_t k = 0;; ++k) {
    const double s = o.phase_s + static_cast<double>(k) / o.rate_hz;
    const TimeNs t = motion_->begin() + fromSeconds(s);
    if (t > motion_->end()) return out;
    if (beginOf(o.missing_s, s) || (k % 2 == 1 && beginOf(o.half_rate_s, s))) continue;
    out.emplace_back(t - offset, k);
  }
}

const rendering::GrayImage& Rig::image(int camera, TimeNs stamp, std::uint64_t number) {
  Camera& c = cameras_[static_cast<std::size_t>(camera)];
  TimeNs t = stamp + fromSeconds(c.options.trueOffset());
  const double s = toSeconds(t - motion_->begin());
  if (beginOf(c.options.black_s, s)) {
    c.shown.width = c.calibration.width;
    c.shown.height = c.calibration.height;
    c.shown.pixels.assign(static_cast<std::size_t>(c.shown.width * c.shown.height), 0);
    return c.shown;
  }
  if (const auto begin = beginOf(c.options.frozen_s, s)) {
    // The one before the stretch, byte for byte.
    const double before = std::ceil((*begin - c.options.phase_s) * c.options.rate_hz) - 1;
    number = static_cast<std::uint64_t>(std::max(0.0, before));
    t = motion_->begin() +
        fromSeconds(c.options.phase_s + static_cast<double>(number) / c.options.rate_hz);
  }
  // The exposure may reach beyond the motion's ends.
  const auto pose = [this, &c, t](double dt) {
    const TimeNs at = std::clamp(t + fromSeconds(dt), motion_->begin(), motion_->end());
    return motion_->poseAt(at) * c.true_T_B_C;
  };
  return c.simulator->take(toSeconds(t - motion_->begin()), number, pose);
}

}  // namespace vir::simulator
