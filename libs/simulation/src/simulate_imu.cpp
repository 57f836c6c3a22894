#include "vir/simulation/simulate_imu.h"

#include <cmath>
#include <stdexcept>

#include "vir/core/random.h"

namespace vir::simulation {
namespace {

Vec3 normal3(Random* random) {
  const double x = random->normal(), y = random->normal(), z = random->normal();
  return {x, y, z};
}

Vec3 clipped(const Vec3& x, double limit) { return x.cwiseMax(-limit).cwiseMin(limit); }

}  // namespace

SimulatedImu simulateImu(const Motion& motion, const ImuSimulationOptions& o) {
  if (!(o.rate_hz > 0)) throw std::invalid_argument("simulateImu: rate_hz must be positive");
  const auto seed = static_cast<std::uint64_t>(o.seed);
  // One sequence per purpose: a change of one setting leaves the other errors as they were.
  Random white(seed, 100), walk(seed, 101), once(seed, 102), loss(seed, 103);
  const double root = std::sqrt(o.rate_hz), step = std::sqrt(1 / o.rate_hz);
  Vec3 bg = o.initial_bias_gyro * normal3(&once);
  Vec3 ba = o.initial_bias_acc * normal3(&once);
  const Vec3 gain_gyro = Vec3::Ones() + o.scale_error * normal3(&once);
  const Vec3 gain_acc = Vec3::Ones() + o.scale_error * normal3(&once);
  const Quat q_G_B = expQuat(o.misalignment_rad * normal3(&once));
  const Vec3 g_W(0, 0, -o.gravity_mps2);
  SimulatedImu out;
  for (int k = 0;; ++k) {
    const TimeNs t = motion.begin() + fromSeconds(k / o.rate_hz);
    if (t > motion.end()) return out;
    const MotionState s = motion.at(t);
    ImuSample r;
    r.t = t;
    r.gyro = gain_gyro.cwiseProduct(q_G_B * s.rate_B) + bg +
             o.gyro_noise_density * root * normal3(&white);
    r.acc = gain_acc.cwiseProduct(s.T_W_B.q.conjugate() * (s.a_W - g_W)) + ba +
            o.acc_noise_density * root * normal3(&white);
    r.gyro = clipped(r.gyro, o.saturation_gyro_radps);
    r.acc = clipped(r.acc, o.saturation_acc_mps2);
    if (!(loss.uniform() < o.dropped_share)) {
      out.samples.push_back(r);
      out.bias_gyro.push_back(bg);
      out.bias_acc.push_back(ba);
    }
    bg += o.gyro_random_walk * step * normal3(&walk);
    ba += o.acc_random_walk * step * normal3(&walk);
  }
}

}  // namespace vir::simulation
