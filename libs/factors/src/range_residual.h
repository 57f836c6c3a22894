#pragma once
/// Internal: pieces of the factors of ranges and nodes.
#include <optional>

#include "vir/factors/node_range_factor.h"

namespace vir::factors {

using Row3 = Eigen::Matrix<double, 1, 3>;

inline Vec3 vec(const double* x) { return {x[0], x[1], x[2]}; }

/// d(Rz(yaw) v)/d(yaw), given v already turned.
inline Vec3 turned(const Vec3& v_W) { return {-v_W.y(), v_W.x(), 0}; }

/// How far a frame is turned about the vertical from where it was, and how that changes with a turn
/// of the frame on the right.
struct HeadingChange {
  HeadingChange(const Quat& q_O_B, const std::optional<Quat>& was_O_B);
  double yaw = 0;
  Row3 by_turn = Row3::Zero();
};

/// Where a node of the long window has its antenna.
struct NodeAntenna {
  NodeAntenna(const NodeFrame& node, const Vec3& motion_O, const Vec3& lever_O);
  Vec3 motion_W, offset_W, p_W;
};
/// Of a distance that grows along `direction` with the antenna.
void nodeJacobian(double scale, const Vec3& direction, const NodeAntenna& antenna, double* j);

/// Whitens and robustifies; returns d(residual)/d(unwhitened residual).
double whiten(const RangeTerm& range, double unwhitened_m, double* residuals);

void anchorJacobian(double scale, const Vec3& direction, double* j);

}  // namespace vir::factors
