#include "vir/estimator/startup.h"

#include <algorithm>
#include <cmath>

#include "packet.h"
#include "vir/core/angles.h"
#include "vir/core/order_statistics.h"
#include "vir/initialization/inertial_alignment.h"

namespace vir::estimator {

void describe(OptionVisitor& v, StartupOptions& o) {
  v.section("Startup", "Initialisation, standing or moving");
  v.value("min_span_s", o.min_span_s, {0.1, 60.0}, "shortest stretch of images to start from");
  v.value("max_span_s", o.max_span_s, {0.2, 60.0}, "longest stretch of images to start from");
  v.value("max_scale_sigma", o.max_scale_sigma, {1e-4, 10.0},
          "relative standard deviation of the scale at which a start is accepted at once");
  v.value("patience_s", o.patience_s, {0.0, 1e6},
          "after this long a start is accepted at patient_scale_sigma");
  v.value("patient_scale_sigma", o.patient_scale_sigma, {1e-4, 10.0},
          "relative standard deviation of the scale at which a late start is accepted");
  v.value("max_tilt_sigma_deg", o.max_tilt_sigma_deg, {1e-3, 90.0},
          "standard deviation of roll and pitch at which a start is accepted");
  v.value("min_parallax_px", o.min_parallax_px, {1.0, 1000.0},
          "median parallax needed before a moving start is tried");
  v.value("min_shared_tracks", o.min_shared_tracks, {8, 10000},
          "tracks that must reach from an early image to the newest");
  v.value("max_reprojection_rms", o.max_reprojection_rms, {0.1, 100.0},
          "reprojection error (in sigma_px) above which a start is refused");
  v.value("iterations", o.iterations, {1, 1000}, "solver iterations per round of the refinement");
  v.value("sigma_bias_gyro", o.sigma_bias_gyro, {1e-6, 10.0},
          "what the gyro bias may be at the start [rad/s]");
  v.value("sigma_bias_acc", o.sigma_bias_acc, {1e-6, 10.0},
          "what the accelerometer bias may be at the start [m/s^2]");
  v.value("allow_standing", o.allow_standing, "start at once when standing still");
}

namespace {

/// A rig: a shorter way is known as well as that [m].
constexpr double kRigWay = 0.5;

struct Parallax {
  int shared = 0;
  double median_px = 0;
};

Parallax parallaxBetween(const vision::TrackedFrame& a, const vision::TrackedFrame& b,
                         const Quat& q_Ca_Cb, double focal_px) {
  Parallax out;
  std::vector<double> d;
  std::size_t j = 0;
  for (const vision::FeatureObservation& o : b.features) {
    while (j < a.features.size() && a.features[j].id < o.id) ++j;
    if (j < a.features.size() && a.features[j].id == o.id) {
      d.push_back((a.features[j].bearing - q_Ca_Cb * o.bearing).norm() * focal_px);
    }
  }
  out.shared = static_cast<int>(d.size());
  if (d.empty()) return out;
  out.median_px = medianInPlace(&d);
  return out;
}

std::string number(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", x);
  return text;
}

}  // namespace

Startup::Startup(const StartupOptions& options, const imu::ImuNoise& noise, const Pose& T_B_C,
                 double focal_px)
    : options_(options), noise_(noise), T_B_C_(T_B_C), focal_px_(focal_px) {}

void Startup::reset() {
  frames_.clear();
  found_shift_s_ = 0;
  since_attempt_ = 0;
  any_offer_ = false;
  reason_ = "waiting for images";
}

void Startup::remember(const vision::TrackedFrame& frame) {
  if (!frame.usable || (!frames_.empty() && frame.t <= frames_.back().t)) return;
  frames_.push_back(frame);
  if (!any_offer_) first_offer_ = frame.t;
  any_offer_ = true;
  while (toSeconds(frames_.back().t - frames_.front().t) > options_.max_span_s + 1e-6) {
    frames_.pop_front();
  }
}

void Startup::shift(TimeNs by) {
  for (vision::TrackedFrame& frame : frames_) frame.t += by;
  first_offer_ += by;
}

StartupStatus Startup::offer(const vision::TrackedFrame& frame, imu::ImuBuffer& imu,
                             const RestDetector& rest, const Pose& origin,
                             window::ShortWindow* window) {
  tried_ = false;
  if (!frame.usable) {
    reason_ = "image not usable: " + frame.reason;
    return StartupStatus::waiting;
  }
  remember(frame);
  if (rig_) window->setRigMisfit(epipolar_px_);
  if (rest.standing()) {
    if (options_.allow_standing && startStanding(frame, imu, rest, origin, window)) {
      return StartupStatus::started_standing;
    }
    reason_ = "standing still";
    return StartupStatus::waiting;
  }
  if (rig_ && startWithRig(imu, origin, window)) return StartupStatus::started_moving;
  if (toSeconds(frames_.back().t - frames_.front().t) < options_.min_span_s) {
    reason_ = "too few images";
    return StartupStatus::waiting;
  }
  if (++since_attempt_ < 2) return StartupStatus::waiting;
  since_attempt_ = 0;
  tried_ = true;
  return startMoving(imu, origin, window) ? StartupStatus::started_moving : StartupStatus::waiting;
}

StartupStatus Startup::offerAgain(double by_s, imu::ImuBuffer& imu, const Pose& origin,
                                  window::ShortWindow* window) {
  if (!tried_) return StartupStatus::waiting;
  const double before = window->timeOffset();
  const std::string reason = reason_, detail = detail_;
  window->setTimeOffset(before + by_s, time_offset_sigma_s_);
  shift(fromSeconds(by_s));
  if (startMoving(imu, origin, window)) {
    found_shift_s_ += by_s;
    return StartupStatus::started_moving;
  }
  window->setTimeOffset(before, time_offset_sigma_s_);
  shift(-fromSeconds(by_s));
  reason_ = reason;
  detail_ = detail;
  return StartupStatus::waiting;
}

bool Startup::startStanding(const vision::TrackedFrame& frame, const imu::ImuBuffer& imu,
                            const RestDetector& rest, const Pose& origin,
                            window::ShortWindow* window) {
  Vec3 gyro, acc;
  double gyro_std = 0, acc_std = 0;
  if (!imu.statistics(rest.since(), frame.t, &gyro, &acc, &gyro_std, &acc_std)) return false;
  State s;
  s.t = frame.t;
  s.T_W_B.q = Quat(rotZ(yawOf(origin.R()))) * gravityAlignedAttitude(acc);
  s.T_W_B.p = origin.p;
  s.bg = gyro;
  s.ba = acc - acc.normalized() * noise_.gravity_mps2;
  window::StartPrior prior;
  prior.bias_gyro = 0.002;
  prior.bias_acc = options_.sigma_bias_acc;
  prior.velocity_mps = 0.01;
  // The accelerometer's bias and the tilt share what was measured: their sum is known well, each
  // alone only as well as the bias.
  prior.tilt_rad = options_.sigma_bias_acc / noise_.gravity_mps2;
  if (time_offset_sigma_s_ > 0) {
    window->setTimeOffset(window->timeOffset(), time_offset_sigma_s_);
  }
  window->start(s, prior, allSights(frame), true);
  found_shift_s_ = 0;
  gyro_bias_ = gyro;
  return true;
}

std::vector<const vision::TrackedFrame*> Startup::selectFrames() const {
  // At most 11 frames, evenly over the stretch, always the newest.
  constexpr int kMaxFrames = 11;
  const int n = static_cast<int>(frames_.size());
  const int count = std::min(kMaxFrames, n);
  std::vector<const vision::TrackedFrame*> out;
  for (int k = 0; k < count; ++k) {
    out.push_back(&frames_[static_cast<std::size_t>(
        std::lround(static_cast<double>(k) * (n - 1) / std::max(1, count - 1)))]);
  }
  return out;
}

bool Startup::enoughMotion(const std::vector<const vision::TrackedFrame*>& frames,
                           imu::ImuBuffer& imu) {
  const vision::TrackedFrame& newest = *frames.back();
  Parallax best;
  double best_flow = 0;
  int most_shared = 0;
  for (std::size_t k = 0; k + 1 < frames.size(); ++k) {
    const imu::Preintegration link =
        imu.integrate(frames[k]->t, newest.t, noise_, gyro_bias_, Vec3::Zero());
    const Quat q = T_B_C_.q.conjugate() * link.dq() * T_B_C_.q;
    const Parallax p = parallaxBetween(*frames[k], newest, q, focal_px_);
    most_shared = std::max(most_shared, p.shared);
    if (p.shared < options_.min_shared_tracks) continue;
    if (p.median_px > best.median_px) {
      best = p;
      best_flow = parallaxBetween(*frames[k], newest, Quat::Identity(), focal_px_).median_px;
    }
  }
  if (most_shared < options_.min_shared_tracks) {
    reason_ = "too few tracks";
    return false;
  }
  if (best.median_px < options_.min_parallax_px) {
    reason_ = best_flow > 3 * options_.min_parallax_px ? "rotation only" : "too little parallax";
    return false;
  }
  return true;
}

bool Startup::startMoving(imu::ImuBuffer& imu, const Pose& origin, window::ShortWindow* window) {
  // The sights depend on the time offset to first order only: a start far from the right one is
  // made again from there.
  constexpr int kRounds = 4;
  constexpr double kCloseS = 0.0015, kFarthestS = 0.1;
  const double given = window->timeOffset();
  double stamped = given;
  const auto restamp = [&](double offset_s) {
    window->clear();
    window->setTimeOffset(offset_s, time_offset_sigma_s_);
    shift(fromSeconds(offset_s) - fromSeconds(stamped));
    stamped = offset_s;
  };
  if (time_offset_sigma_s_ > 0) window->setTimeOffset(given, time_offset_sigma_s_);
  for (int round = 0; round < kRounds; ++round) {
    if (!startMovingOnce(imu, origin, window)) break;
    const double found = window->timeOffset();
    if (time_offset_sigma_s_ <= 0 || std::abs(found - stamped) < kCloseS) {
      found_shift_s_ = stamped - given;
      return true;
    }
    reason_ = "the camera's time offset is not known";
    if (std::abs(found - given) > kFarthestS) break;
    restamp(found);
  }
  if (time_offset_sigma_s_ > 0) restamp(given);
  return false;
}

bool Startup::startMovingOnce(imu::ImuBuffer& imu, const Pose& origin,
                              window::ShortWindow* window) {
  const std::vector<const vision::TrackedFrame*> selected = selectFrames();
  std::vector<initialization::AlignmentFrame> frames;
  const auto links = [&](const Vec3& bg) {
    for (std::size_t k = 1; k < frames.size(); ++k) {
      frames[k].link = imu.integrate(frames[k - 1].t, frames[k].t, noise_, bg, Vec3::Zero());
    }
  };
  for (const vision::TrackedFrame* f : selected) {
    frames.push_back({f->t, {}, imu::Preintegration(noise_, Vec3::Zero(), Vec3::Zero())});
    for (const vision::FeatureObservation& o : f->features)
      frames.back().sights.push_back({o.id, o.bearing});
  }
  links(gyro_bias_);
  const initialization::GyroBiasEstimate bias =
      initialization::estimateGyroBias(frames, T_B_C_.q, focal_px_, gyro_bias_);
  if (!bias.ok) {
    reason_ = bias.reason;
    return false;
  }
  gyro_bias_ = bias.bias;
  if (!enoughMotion(selected, imu)) return false;
  links(gyro_bias_);
  const initialization::InertialAlignment a =
      initialization::alignInertial(frames, T_B_C_, noise_.gravity_mps2, focal_px_);
  if (!a.ok) {
    reason_ = a.reason;
    return false;
  }
  const Quat q_W_B0 = Quat(rotZ(yawOf(origin.R()))) * gravityAlignedAttitude(-a.g_B0);
  for (std::size_t k = 0; k < frames.size(); ++k) {
    State s;
    s.t = frames[k].t;
    s.T_W_B.q = (q_W_B0 * a.q_B0_B[k]).normalized();
    s.T_W_B.p = origin.p + q_W_B0 * a.p_B0[k];
    s.v = q_W_B0 * a.v_B0[k];
    s.bg = gyro_bias_;
    if (k == 0) {
      window::StartPrior prior;
      prior.bias_gyro = options_.sigma_bias_gyro;
      prior.bias_acc = options_.sigma_bias_acc;
      window->start(s, prior, allSights(*selected[k]), false);
    } else {
      window->push(s, std::move(frames[k].link), allSights(*selected[k]), false);
    }
    window->keepNewest();
  }
  detail_ = "gyro bias residual " + number(bias.rms_px) + " px, alignment residual " +
            number(a.residual_px) + " px";
  if (refine(window)) return true;
  window->clear();
  return false;
}

bool Startup::refine(window::ShortWindow* window) {
  window::SolveSummary solve;
  for (int round = 0; round < 3; ++round) {
    window->triangulate();
    solve = window->optimise(options_.iterations);
    if (!solve.usable) {
      reason_ = "inconsistent";
      return false;
    }
    window->rejectOutliers();
  }
  if (window->landmarksInNewest() < 15) {
    reason_ = "the tracks do not fit the camera's model and the readings";
    return false;
  }
  const window::WindowAccuracy acc = window->accuracy();
  // Who hardly moves has no way of which the scale could be told, and needs none with depth.
  const double way = by_rig_ ? std::max(acc.baseline_m, kRigWay) : acc.baseline_m;
  const double scale_sigma = acc.baseline_sigma_m / std::max(1e-9, way);
  detail_ += ", refined: reprojection " + number(solve.reprojection_rms) + " sigma, cost " +
             number(solve.final_cost) + " of " + std::to_string(solve.sights) +
             " sights, baseline " + number(acc.baseline_m) + " m, scale sigma " +
             number(scale_sigma) + ", tilt sigma " + number(acc.tilt_sigma_rad * 180 / kPi) +
             " deg";
  if (solve.reprojection_rms > options_.max_reprojection_rms) {
    reason_ = "inconsistent";
    return false;
  }
  const bool patient = toSeconds(frames_.back().t - first_offer_) >= options_.patience_s;
  const double limit = patient ? std::max(options_.max_scale_sigma, options_.patient_scale_sigma)
                               : options_.max_scale_sigma;
  if (!(scale_sigma < limit) || !(acc.tilt_sigma_rad * 180 / kPi < options_.max_tilt_sigma_deg)) {
    reason_ = "scale uncertain";
    return false;
  }
  return true;
}

}  // namespace vir::estimator
