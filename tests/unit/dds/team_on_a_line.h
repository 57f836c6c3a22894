#pragma once
#include "vir/team/peer_report.h"

namespace vir::test {

constexpr TimeNs kLineStart = 1'700'000'000'000'000'000;

/// The i-th report of a robot that goes along x, 0.1 m and 0.05 s at a time.
inline team::PeerReport reportOnALine(std::uint32_t robot, int i) {
  team::PeerReport r;
  r.robot = robot;
  r.sequence = static_cast<std::uint32_t>(i);
  r.t = kLineStart + 50'000'000 * static_cast<TimeNs>(i);
  r.T_W_B = {Quat(Eigen::AngleAxisd(0.25, Vec3::UnitZ())), Vec3(0.1 * i, 2, 3)};
  for (int k = 0; k < 6; ++k) r.covariance(k, k) = 0.25 * (k + 1);
  r.covariance(0, 5) = r.covariance(5, 0) = 0.125;
  r.p_B_U = Vec3(0.5, 0.25, -0.125);
  r.anchors.emplace_back(7, SentPosition{r.t, Vec3(4, 5, 6), 0.5 * Mat3::Identity()});
  r.ranges.push_back({r.t - 1000, 3, 7.25, 0.125, Vec3::Zero()});
  if (i % 10 == 0) {
    Eigen::Matrix4d C = 0.04 * Eigen::Matrix4d::Identity();
    C(0, 3) = C(3, 0) = 0.01;
    r.team = team::TeamTold{team::CommonFrame{{2, 99, 1}, r.t - 5, r.t - 3, {0.25, Vec3(7, 8, 9)}},
                            {{{9, 1234567890123, 4}, {-1.5, Vec3(1, 2, 3)}, C}}};
  }
  return r;
}

}  // namespace vir::test
