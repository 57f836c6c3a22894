#pragma once
/// Runs a short window over the simulated scene the way the estimator does, without a tracker.
#include <cmath>
#include <vector>

#include "vir_test_scene.h"

namespace vir_test {

inline vir::imu::ImuNoise unscaledNoise() {
  vir::imu::ImuNoise n;
  n.noise_scale = 1;
  n.acc_random_walk = 1e-4;
  return n;
}

struct WindowDriver {
  WindowDriver(Motion motion, unsigned seed, const vir::window::WindowOptions& window_options,
               double t0_s = 1.0, const vir::window::LongWindowOptions& long_options = {})
      : scene(std::move(motion), seed),
        options(window_options),
        long_window(long_options),
        window(options, noise, Scene::calibration()),
        t(vir::fromSeconds(t0_s)),
        next_imu(t - vir::fromSeconds(0.01)) {
    window.attach(&long_window);
  }

  void feedImu() {
    for (; next_imu <= t + vir::fromSeconds(0.005); next_imu += vir::fromSeconds(0.005)) {
      const vir::ImuSample sample = scene.imu(next_imu);
      imu.add(imu_error ? imu_error(sample) : sample);
    }
  }

  void start(const vir::State& state, const vir::window::StartPrior& prior, bool standing = false) {
    feedImu();
    std::vector<vir::vision::FeatureObservation> features = observe();
    if (spoil) spoil(&features);
    window.start(state, prior, features, standing);
    long_window.start(state.t, state.T_W_B, state.T_W_B, 1e-3, 1e-3);
  }

  /// Adds the next image with its prediction, optionally disturbed.
  void push(double period_s, double disturb = 0, bool standing = false) {
    const vir::State from = window.newest();
    t += vir::fromSeconds(period_s);
    feedImu();
    vir::imu::Preintegration link =
        imu.integrate(from.t, t, noise, from.bg, from.ba, nullptr, window.imuIntrinsics());
    vir::State s = vir::window::predict(from, link, noise.gravity_mps2, t);
    if (disturb > 0) {
      s.T_W_B.p += scene.normal3(disturb);
      s.T_W_B.q = (s.T_W_B.q * vir::expQuat(scene.normal3(0.3 * disturb))).normalized();
      s.v += scene.normal3(disturb);
    }
    std::vector<vir::vision::FeatureObservation> features = observe();
    if (spoil) spoil(&features);
    window.push(s, std::move(link), features, standing);
    if (pushed) pushed();
    imu.dropBefore(from.t - vir::fromSeconds(1.0));
  }

  /// One image as the estimator's loop handles it.
  void step(double period_s, bool standing = false) {
    push(period_s, 0, standing);
    const bool keyframe = window.newestIsKeyframe();
    window.triangulate();
    last = keyframe || options.full_every_image ? window.optimise(options.iterations)
                                                : window.optimiseNewest(options.iterations_newest);
    rejected += static_cast<long>(window.rejectOutliers().size());
    if (keyframe) window.updateCovariance();
    window.slide(keyframe);
    keyframes += keyframe;
  }

  /// The image that is stamped t: taken `camera_late_s` afterwards.
  std::vector<vir::vision::FeatureObservation> observe() {
    return scene.observe(t + vir::fromSeconds(camera_late_s));
  }

  double positionError() const {
    return (window.newest().T_W_B.p - scene.truth(window.newest().t).T_W_B.p).norm();
  }

  Scene scene;
  vir::imu::ImuNoise noise = unscaledNoise();
  vir::window::WindowOptions options;
  vir::window::LongWindow long_window;
  vir::window::ShortWindow window;
  vir::imu::ImuBuffer imu;
  TimeNs t, next_imu;
  std::function<void(std::vector<vir::vision::FeatureObservation>*)> spoil;
  std::function<vir::ImuSample(vir::ImuSample)> imu_error;  ///< what the IMU makes of a reading
  std::function<void()> pushed;  ///< after every image, before it is worked on
  double camera_late_s = 0;
  vir::window::SolveSummary last;
  int keyframes = 0;
  long rejected = 0;  ///< tracks
};

}  // namespace vir_test
