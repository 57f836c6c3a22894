/// What a run asks of its loops at every image, without those who look for them.
#include <algorithm>

#include "vir/mission/loop_closer.h"

namespace vir::mission {
namespace {

/// A run that begins with a map is looked for this often.
constexpr double kSearchInterval_s = 0.1;

}  // namespace

bool KeyframePace::within(double seconds) const {
  return !last_ || toSeconds(last_->t - first_) < seconds;
}

bool KeyframePace::searches(bool found) const { return !found && within(kSearch_s); }

bool KeyframePace::wants(const StateEstimate& e, bool found) const {
  if (!e.valid) return false;
  if (!last_) return true;
  const State& s = e.state;
  if (s.t <= last_->t) return false;  // after a clock that was set back
  if (e.segment != segment_) return true;
  const double interval_s =
      searches(found) ? std::min(kSearchInterval_s, options_.interval_s) : options_.interval_s;
  if (toSeconds(s.t - last_->t) < interval_s) return false;
  const Pose motion = last_->T_W_B.inverse() * s.T_W_B;
  return motion.p.norm() >= options_.moved_m ||
         motion.q.angularDistance(Quat::Identity()) >= options_.turned_rad;
}

void KeyframePace::took(const StateEstimate& e) {
  if (!last_) first_ = e.state.t;
  last_ = StampedPose{e.state.t, e.state.T_W_B};
  segment_ = e.segment;
}

void Correction::apply(StateEstimate* e) const {
  const Mat3 R = rotZ(T_M_W.yaw_rad);
  e->state.T_W_B = T_M_W.pose() * e->state.T_W_B;
  e->state.v = R * e->state.v;
  Eigen::Matrix<double, 6, 6> turn = Eigen::Matrix<double, 6, 6>::Identity();
  turn.topLeftCorner<3, 3>() = R;
  if (known) {
    const Eigen::Matrix4d& S = *known;
    // Of the turn only the part about the vertical: roll and pitch are the estimator's.
    const Mat3 R_M_B = e->state.T_W_B.R();
    Mat3 yaw = Mat3::Identity();
    yaw(2, 2) = S(3, 3);
    Eigen::Matrix<double, 6, 6> J = Eigen::Matrix<double, 6, 6>::Zero();
    J.topLeftCorner<3, 3>() = S.topLeftCorner<3, 3>();
    J.topRightCorner<3, 3>() = S.topRightCorner<3, 1>() * R_M_B.row(2);
    J.bottomLeftCorner<3, 3>() = R_M_B.row(2).transpose() * S.bottomLeftCorner<1, 3>();
    J.bottomRightCorner<3, 3>() = R_M_B.transpose() * yaw * R_M_B;
    turn = J * turn;
  }
  e->covariance = turn * e->covariance * turn.transpose();
}

}  // namespace vir::mission
