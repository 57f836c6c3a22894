/// A start with depth from several cameras: standing or moving, within a few images.
#include <algorithm>

#include "packet.h"
#include "vir/core/angles.h"
#include "vir/estimator/startup.h"
#include "vir/initialization/inertial_alignment.h"

namespace vir::estimator {
namespace {

/// A start with a rig, from so long a stretch of images on [s].
constexpr double kRigSpanS = 0.14;
/// Matches further beside their curves are those of another calibration [px]; depth is known of so
/// many landmarks.
constexpr double kRigFitsPx = 1.0;
constexpr std::size_t kRigLandmarks = 15;

}  // namespace

bool Startup::rigFits() const { return epipolar_px_ > 0 && epipolar_px_ <= kRigFitsPx; }

bool Startup::startWithRig(imu::ImuBuffer& imu, const Pose& origin, window::ShortWindow* window) {
  if (!rigFits()) return false;
  // The latest that are enough: the tilt may have to wait for more.
  std::size_t first = 0;
  while (first + 4 < frames_.size() &&
         toSeconds(frames_.back().t - frames_[first + 1].t) >= options_.min_span_s) {
    ++first;
  }
  while (first + 1 < frames_.size() && frames_[first].further.size() < kRigLandmarks) ++first;
  if (toSeconds(frames_.back().t - frames_[first].t) < kRigSpanS) return false;
  Vec3 gyro, acc;
  double gyro_std = 0, acc_std = 0;
  if (!imu.statistics(frames_[first].t, frames_.back().t, &gyro, &acc, &gyro_std, &acc_std)) {
    return false;
  }
  State s;
  s.t = frames_[first].t;
  s.T_W_B.q = Quat(rotZ(yawOf(origin.R()))) * gravityAlignedAttitude(acc);
  s.T_W_B.p = origin.p;
  s.bg = gyro_bias_;
  window::StartPrior prior;
  prior.bias_gyro = options_.sigma_bias_gyro;
  prior.bias_acc = options_.sigma_bias_acc;
  window->start(s, prior, allSights(frames_[first]), false);
  window->triangulate();
  if (window->landmarksInNewest() < static_cast<int>(kRigLandmarks)) {
    window->clear();
    return false;
  }
  const std::size_t most = 9, step = std::max<std::size_t>(1, (frames_.size() - first) / most);
  std::size_t k = first;
  while (k + 1 < frames_.size()) {
    const std::size_t next = std::min(k + step, frames_.size() - 1);
    imu::Preintegration link =
        imu.integrate(frames_[k].t, frames_[next].t, noise_, gyro_bias_, Vec3::Zero());
    const double dt = toSeconds(frames_[next].t - frames_[k].t);
    Pose guess = s.T_W_B;
    guess.p += dt * s.v;
    guess.q = (guess.q * link.dq()).normalized();
    const std::vector<vision::FeatureObservation> sights = allSights(frames_[next]);
    const Pose seen = window->resect(guess, sights, 0).T_W_B;
    s.v = (seen.p - s.T_W_B.p) / dt;
    s.T_W_B = seen;
    s.t = frames_[next].t;
    window->push(s, std::move(link), sights, false);
    window->keepNewest();
    window->triangulate();
    k = next;
  }
  detail_ = "by the cameras' own depth";
  by_rig_ = true;
  const bool ok = refine(window);
  by_rig_ = false;
  if (ok) {
    found_shift_s_ = 0;
    gyro_bias_ = window->newest().bg;
  } else {
    window->clear();
  }
  return ok;
}

}  // namespace vir::estimator
