/// Where the short window, the long window and the ranges meet.
#include <algorithm>

#include "back_end.h"
#include "start_sigma.h"

namespace vir::estimator {
namespace {

/// A range older than the frame before it by more is of no use [s].
constexpr double kLateRangeS = 0.15;
/// Per second without a state: how far a restarted odometry may be off.
constexpr double kLostSpeed = 0.5;
constexpr double kLostPosition = 1.0, kLostYaw = 0.1;
/// Solver iterations when an anchor has just been found or changed.
constexpr int kIterationsOnChange = 6;

/// Pose between two states: cubic in position (it knows both velocities), slerp in attitude.
Pose between(const State& a, const State& b, TimeNs t) {
  const double h = toSeconds(b.t - a.t);
  if (h <= 0) return b.T_W_B;
  const double s = toSeconds(t - a.t), u = s / h;
  if (u <= 0) return {a.T_W_B.q, a.T_W_B.p + a.v * s};
  const double u2 = u * u, u3 = u2 * u;
  const Vec3 p = (2 * u3 - 3 * u2 + 1) * a.T_W_B.p + (u3 - 2 * u2 + u) * h * a.v +
                 (3 * u2 - 2 * u3) * b.T_W_B.p + (u3 - u2) * h * b.v;
  return {a.T_W_B.q.slerp(std::min(u, 1.0), b.T_W_B.q), p};
}

}  // namespace

void BackEnd::attachRanges(const State& previous, const State& newest) {
  const std::vector<Range> due = ranges.dueUntil(newest.t);
  if (due.empty()) return;
  const Pose T_B_O = newest.T_W_B.inverse();
  const Mat3 R_W_O = rotZ(long_window.head().x[3]);
  AntennaPrediction antenna;
  antenna.inner_covariance =
      R_W_O * window->newestCovariance().topLeftCorner<3, 3>() * R_W_O.transpose();
  std::vector<Range> late;
  for (const Range& r : due) {
    if (r.t < previous.t - fromSeconds(kLateRangeS)) {
      late.push_back(r);
      continue;
    }
    const Pose T_O_B = between(previous, newest, r.t);
    antenna.p_W = long_window.antennaToWorld(T_O_B * r.p_B_U, T_O_B.q * r.p_B_U);
    window::HeldRange held;
    if (!ranges.accept(r, antenna, &held)) continue;
    held.motion = T_B_O * T_O_B.p;
    held.lever = T_B_O.q * (T_O_B.q * r.p_B_U);
    window->addRange(held);
  }
  ranges.discard(late, RangeDecision::too_late);
}

std::vector<window::HeldRange> BackEnd::heldRanges(std::uint64_t key) const {
  std::vector<window::HeldRange> out;
  const auto wanted = [key](const window::HeldRange& r) { return r.anchor == key && !r.reference; };
  for (const window::LongNode& n : long_window.nodes()) addHeldInWorld(n, n.ranges, wanted, &out);
  for (window::HeldRange r : window->rangesInO(key)) {
    r.motion = long_window.antennaToWorld(r.motion, r.lever);
    r.lever.setZero();
    out.push_back(r);
  }
  return out;
}

std::vector<window::HeldRange> BackEnd::heldDifferences() const {
  std::vector<window::HeldRange> out;
  const auto wanted = [](const window::HeldRange& r) { return r.reference.has_value(); };
  for (const window::LongNode& n : long_window.nodes()) addHeldInWorld(n, n.ranges, wanted, &out);
  for (window::HeldRange r : window->differencesInO()) {
    r.motion = long_window.antennaToWorld(r.motion, r.lever);
    r.lever.setZero();
    out.push_back(r);
  }
  return out;
}

void BackEnd::updateAnchors(TimeNs t) {
  window->updateCovariance();
  const auto held = [this](std::uint64_t key) { return heldRanges(key); };
  const auto differences = [this] { return heldDifferences(); };
  if (ranges.update(t, held, window->rangesAtOldest(), differences)) {
    window->optimise(kIterationsOnChange);
    window->updateCovariance();
  }
  collectRangeWarnings();
}

void BackEnd::startLongWindow() {
  const State oldest = window->oldest();
  if (long_window.empty()) {
    long_window.start(oldest.t, oldest.T_W_B, oldest.T_W_B, kStartSigma, kStartSigma);
  } else {
    // A new segment: the chain goes on over an edge that says how little is known.
    const double lost = toSeconds(oldest.t - long_window.head().t);
    Eigen::Vector4d sigma;
    sigma << Vec3::Constant(kLostPosition + kLostSpeed * std::max(0.0, lost)), kLostYaw;
    long_window.advance(oldest.t, oldest.T_W_B, {}, sigma.cwiseAbs2().asDiagonal(),
                        window::NodeTie::lost);
  }
  const State newest = window->newest();
  ranges.discard(ranges.dueUntil(newest.t), RangeDecision::before_the_start);
}

State BackEnd::inWorld(const State& s) const {
  State out = s;
  out.T_W_B = long_window.toWorld(s.T_W_B);
  out.v = long_window.turnToWorld(s.v);
  return out;
}

Eigen::Matrix<double, 6, 6> BackEnd::covarianceInWorld() const {
  using Mat6 = Eigen::Matrix<double, 6, 6>;
  const Eigen::MatrixXd& joint = long_window.jointCovariance();
  if (joint.rows() < 5) return Mat6::Zero();
  const Pose T_W_B = long_window.toWorld(window->newest().T_W_B);
  Mat6 turn = Mat6::Identity();
  turn.topLeftCorner<3, 3>() = rotZ(long_window.head().x[3]);
  Eigen::Matrix<double, 6, 4> J = Eigen::Matrix<double, 6, 4>::Zero();
  J.topLeftCorner<3, 3>().setIdentity();
  J.topRightCorner<3, 1>() = Vec3::UnitZ().cross(T_W_B.p - long_window.head().position());
  J.bottomRightCorner<3, 1>() = T_W_B.R().row(2).transpose();
  Mat6 out = turn * window->newestCovariance() * turn.transpose() +
             J * joint.topLeftCorner<4, 4>() * J.transpose();
  if (!long_window.scaleFrozen()) {
    Eigen::Matrix<double, 6, 1> longer = Eigen::Matrix<double, 6, 1>::Zero();
    longer.head<3>() = long_window.head().position() - T_W_B.p;
    const Mat6 cross = J * joint.block<4, 1>(0, 4) * longer.transpose();
    out += cross + cross.transpose() + joint(4, 4) * longer * longer.transpose();
  }
  return out;
}

FollowedPose BackEnd::followed(const window::LongNode& n) {
  Eigen::Vector4d to_next = Eigen::Vector4d::Zero();
  if (n.tie == window::NodeTie::followed) to_next = n.covariance.diagonal();
  return {{n.t, n.T_W_B()}, n.T_O_B, std::exp(-n.x[4]), n.motion_O, to_next};
}

void BackEnd::collectRetired() {
  for (const window::LongNode& n : long_window.takeRetired()) {
    old_keyframes.add(followed(n));
  }
  for (const Landmark& l : window->takeRetiredLandmarks()) {
    old_landmarks.add({l.id, long_window.pointToWorld(l.p_W)});
  }
}

void BackEnd::tellSights(const vision::TrackedFrame& frame, TimeNs t_image) {
  KeyframeSights out;
  out.t_image = t_image;
  std::map<std::uint64_t, Vec2> pixel;
  for (const vision::FeatureObservation& f : frame.features) pixel[f.id] = f.px;
  for (const window::LandmarkDistance& l : window->distancesInNewest()) {
    const auto at = pixel.find(l.id);
    if (at != pixel.end()) out.of.push_back({at->second, l.inverse_distance, l.sigma});
  }
  sights.push_back(std::move(out));
}

std::vector<State> BackEnd::keyframes() const {
  std::vector<State> out;
  const auto add = [&out](TimeNs t, const Pose& T_W_B) {
    out.emplace_back();
    out.back().t = t;
    out.back().T_W_B = T_W_B;
  };
  for (const StampedPose& k : old_keyframes.kept()) add(k.t, k.T_W_B);
  for (const window::LongNode& n : long_window.nodes()) add(n.t, n.T_W_B());
  if (window) {
    for (const State& s : window->states()) out.push_back(inWorld(s));
  }
  return out;
}

std::vector<FollowedPose> BackEnd::followedInWindows() const {
  std::vector<FollowedPose> out;
  for (const window::LongNode& n : long_window.nodes()) out.push_back(followed(n));
  if (window) {
    const double scale = long_window.empty() ? 1 : std::exp(-long_window.head().x[4]);
    for (const State& s : window->states()) {
      // The long window's newest is the short one's oldest.
      if (!out.empty() && s.t <= out.back().t) continue;
      out.push_back(
          {{s.t, inWorld(s).T_W_B}, s.T_W_B, scale, Vec3::Zero(), Eigen::Vector4d::Zero()});
    }
  }
  return out;
}

std::vector<Landmark> BackEnd::landmarks() const {
  std::vector<Landmark> out = old_landmarks.values();
  if (window) {
    for (const Landmark& l : window->landmarks()) {
      out.push_back({l.id, long_window.pointToWorld(l.p_W)});
    }
  }
  return out;
}

}  // namespace vir::estimator
