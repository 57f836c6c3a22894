#include "vir/simulation/simulate_odometry.h"

#include <cmath>
#include <stdexcept>

#include "vir/core/random.h"

namespace vir::simulation {
namespace {

Vec3 normal3(Random* random) {
  const double x = random->normal(), y = random->normal(), z = random->normal();
  return {x, y, z};
}

}  // namespace

Trajectory simulateOdometry(const Motion& motion, const OdometrySimulationOptions& o) {
  if (!(o.rate_hz > 0)) throw std::invalid_argument("simulateOdometry: rate_hz must be positive");
  const auto seed = static_cast<std::uint64_t>(o.seed);
  Random drift(seed, 300), white(seed, 301);
  const double dt = 1 / o.rate_hz, root = std::sqrt(dt);
  const double keep = std::exp(-dt / o.scale_wander_s);
  const Trajectory truth = motion.sampled(o.rate_hz);
  const Pose& first = truth.front().T_W_B;
  // Its heading is off by this against W.
  double yaw = -yawOf(first.R());
  double wander = drift.normal();
  Vec3 p = Vec3::Zero(), last = first.p;
  Trajectory out;
  for (const StampedPose& s : truth) {
    const double scale = 1 + o.scale_error + o.scale_wander * wander;
    p += scale * (rotZ(yaw) * (s.T_W_B.p - last));
    last = s.T_W_B.p;
    Pose T;
    T.p = p + o.position_noise_m * normal3(&white);
    T.q = (Quat(rotZ(yaw)) * s.T_W_B.q * expQuat(o.attitude_noise_rad * normal3(&white)))
              .normalized();
    out.push_back({s.t, T});
    wander = keep * wander + std::sqrt(1 - keep * keep) * drift.normal();
    yaw += o.yaw_drift_radps * dt + o.yaw_walk * root * drift.normal();
    p += o.position_walk * root * normal3(&drift);
  }
  return out;
}

}  // namespace vir::simulation
