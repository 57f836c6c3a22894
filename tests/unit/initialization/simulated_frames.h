#pragma once
/// Start-up windows made from the simulated scene.
#include <cmath>
#include <vector>

#include "vir/initialization/inertial_alignment.h"
#include "vir_test_scene.h"

namespace vir_test {

/// Images every `period_s` from t0 on, links integrated with the given bias.
inline std::vector<vir::initialization::AlignmentFrame> framesOf(Scene& scene, double t0_s,
                                                                 int count, double period_s,
                                                                 const Vec3& bias_gyro) {
  vir::imu::ImuBuffer imu;
  const double end = t0_s + count * period_s + 0.02;
  for (int k = 0; t0_s - 0.01 + 0.005 * k < end; ++k) {
    imu.add(scene.imu(vir::fromSeconds(t0_s - 0.01 + 0.005 * k)));
  }
  std::vector<vir::initialization::AlignmentFrame> out;
  for (int k = 0; k < count; ++k) {
    const TimeNs t = vir::fromSeconds(t0_s + k * period_s);
    std::vector<vir::initialization::AlignmentSight> sights;
    for (const vir::vision::FeatureObservation& o : scene.observe(t))
      sights.push_back({o.id, o.bearing});
    vir::imu::Preintegration link(vir::imu::ImuNoise(), bias_gyro, Vec3::Zero());
    if (k > 0) link = imu.integrate(out.back().t, t, vir::imu::ImuNoise(), bias_gyro, Vec3::Zero());
    out.push_back({t, sights, link});
  }
  return out;
}

/// Every tenth sight of a frame is moved by `px` pixels, in turn to each side: what a tracker with
/// an outlier test of its own may still let through.
inline void spoilTenPercent(std::vector<vir::initialization::AlignmentFrame>* frames, double px) {
  int turn = 0;
  for (vir::initialization::AlignmentFrame& f : *frames) {
    for (std::size_t k = static_cast<std::size_t>(turn % 7); k < f.sights.size(); k += 10) {
      const double angle = 2.4 * ++turn;
      f.sights[k].bearing += px / Scene::kFocal * Vec3(std::cos(angle), std::sin(angle), 0);
      f.sights[k].bearing.normalize();
    }
  }
}

/// Every tenth sight of a frame gets the bearing of another track: grossly wrong matches.
inline void mixUpTenPercent(std::vector<vir::initialization::AlignmentFrame>* frames) {
  for (vir::initialization::AlignmentFrame& f : *frames) {
    for (std::size_t k = 0; k + 5 < f.sights.size(); k += 10) {
      f.sights[k].bearing = f.sights[k + 5].bearing;
    }
  }
}

}  // namespace vir_test
