#include "frame_history.h"

#include <algorithm>
#include <cmath>

#include "csv_text.h"
#include "vir/geometry/finite_pose.h"

namespace vir::results {
namespace {

std::string withoutNumbers(std::string text) {
  text.erase(std::remove_if(text.begin(), text.end(),
                            [](char c) { return (c >= '0' && c <= '9') || c == '.'; }),
             text.end());
  return text;
}

Vec3 rootOf(const Vec3& variance) {
  Vec3 out;
  for (int i = 0; i < 3; ++i) out[i] = std::sqrt(std::max(0.0, csv::clean(variance[i])));
  return out;
}

FrameSample sampleOf(const StateEstimate& e) {
  FrameSample s;
  s.t = e.state.t;
  s.valid = e.valid && isFinite(e.state.T_W_B);
  s.state = e.state;
  const Eigen::Matrix<double, 6, 1> variance = e.covariance.diagonal();
  s.sigma_p = rootOf(variance.head<3>());
  s.sigma_r = rootOf(variance.tail<3>());
  s.tracks = e.tracks;
  s.landmarks = e.landmarks;
  s.reprojection_rms = e.reprojection_rms;
  s.inertial_rms = e.inertial_rms;
  return s;
}

}  // namespace

void FrameHistory::add(const StateEstimate& estimate) {
  noteEvent(estimate);
  ms_ = std::max(ms_, csv::clean(estimate.ms.total));
  if (seen_++ % stride_ != 0) return;
  samples_.push_back(sampleOf(estimate));
  samples_.back().ms = ms_;
  ms_ = 0;
  if (samples_.size() < 2 * kShown) return;
  for (std::size_t i = 0; 2 * i < samples_.size(); ++i) {
    const double most = std::max(samples_[2 * i].ms, samples_[2 * i + 1].ms);
    samples_[i] = samples_[2 * i];
    samples_[i].ms = most;
  }
  samples_.resize(samples_.size() / 2);
  stride_ *= 2;
}

void FrameHistory::changeFrame(const Pose& T_new_old) {
  for (FrameSample& s : samples_) {
    s.state.T_W_B = T_new_old * s.state.T_W_B;
    s.state.v = T_new_old.q * s.state.v;
  }
}

void FrameHistory::noteEvent(const StateEstimate& e) {
  std::string health = healthText(e);
  if (e.segment != segment_) health += "; starts anew, positions are not tied to those before";
  // "no landmarks for 1.5 s" and "1.6 s" are one event.
  const bool same = withoutNumbers(health) == withoutNumbers(health_);
  health_ = healthText(e);
  segment_ = e.segment;
  if (same || events_.size() >= kMostEvents) return;
  const bool bad = e.health == Health::doubtful || e.health == Health::lost;
  events_.push_back({e.state.t, health, bad});
}

}  // namespace vir::results
