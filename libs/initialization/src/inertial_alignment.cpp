#include "vir/initialization/inertial_alignment.h"

#include <Eigen/Dense>
#include <cmath>
#include <map>

namespace vir::initialization {
namespace {

using Mat6 = Eigen::Matrix<double, 6, 6>;
using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat36 = Eigen::Matrix<double, 3, 6>;

/// Camera centre as a linear function of y = (v0, g): c = C y + k, in the first body frame.
struct CentreModel {
  Mat36 C;
  Vec3 k;
  Quat q_B0_C;
};

struct TrackSight {
  std::size_t frame;
  Vec3 d;  ///< bearing in the first body frame's axes
};

/// Normal equations of one track in its point X (3) and y (6); residual (I - d d^T)(X - c) / depth.
void addTrack(const std::vector<TrackSight>& sights, const std::vector<CentreModel>& centre,
              const std::vector<double>& weight, Mat6* N, Vec6* b, double* c0) {
  Mat3 Hxx = Mat3::Zero();
  Mat36 Hxy = Mat36::Zero();
  Mat6 Hyy = Mat6::Zero();
  Vec3 bx = Vec3::Zero();
  Vec6 by = Vec6::Zero();
  double cc = 0;
  for (std::size_t i = 0; i < sights.size(); ++i) {
    const CentreModel& c = centre[sights[i].frame];
    const Mat3 P = weight[i] * (Mat3::Identity() - sights[i].d * sights[i].d.transpose());
    const Mat36 PC = P * c.C;
    Hxx += P;
    Hxy -= PC;
    Hyy += c.C.transpose() * PC;
    bx += P * c.k;
    by -= PC.transpose() * c.k;
    cc += c.k.dot(P * c.k);
  }
  const Mat3 inv = (Hxx + 1e-9 * Hxx.trace() * Mat3::Identity()).inverse();
  *N += Hyy - Hxy.transpose() * inv * Hxy;
  *b += by - Hxy.transpose() * inv * bx;
  *c0 += cc - bx.dot(inv * bx);
}

Vec3 pointOf(const std::vector<TrackSight>& sights, const std::vector<CentreModel>& centre,
             const Vec6& y) {
  Mat3 H = Mat3::Zero();
  Vec3 b = Vec3::Zero();
  for (const TrackSight& s : sights) {
    const Mat3 P = Mat3::Identity() - s.d * s.d.transpose();
    H += P;
    b += P * (centre[s.frame].C * y + centre[s.frame].k);
  }
  return (H + 1e-12 * H.trace() * Mat3::Identity()).ldlt().solve(b);
}

/// Minimises y^T N y - 2 b^T y with |g| = G; y = (v0, g). False if no minimum is found.
bool solveConstrained(const Mat6& N, const Vec6& b, double G, Vec6* y) {
  const Mat3 Nvv = N.topLeftCorner<3, 3>();
  const Eigen::LDLT<Mat3> ldlt(Nvv + 1e-12 * Nvv.trace() * Mat3::Identity());
  const Mat3 Nvg = N.topRightCorner<3, 3>();
  const Mat3 S = N.bottomRightCorner<3, 3>() - Nvg.transpose() * ldlt.solve(Nvg);
  const Vec3 s = b.tail<3>() - Nvg.transpose() * ldlt.solve(b.head<3>());
  const Eigen::SelfAdjointEigenSolver<Mat3> eig(0.5 * (S + S.transpose()));
  const Vec3 mu = eig.eigenvalues();
  const Vec3 z = eig.eigenvectors().transpose() * s;
  // |g(lambda)|^2 = sum (z_i / (mu_i + lambda))^2 falls monotonically for lambda > -mu_min.
  const auto length = [&](double lambda) {
    return (z.array() / (mu.array() + lambda)).matrix().norm();
  };
  const double scale = std::max(mu[2], 1e-12);
  double lo = -mu[0] + 1e-12 * scale, hi = -mu[0] + scale;
  for (int i = 0; i < 200 && length(hi) > G; ++i) hi = -mu[0] + (hi + mu[0]) * 2.0;
  if (!(length(lo) >= G)) return false;
  for (int i = 0; i < 200; ++i) {
    const double mid = 0.5 * (lo + hi);
    (length(mid) > G ? lo : hi) = mid;
  }
  const Vec3 g = eig.eigenvectors() * (z.array() / (mu.array() + 0.5 * (lo + hi))).matrix();
  y->tail<3>() = g.normalized() * G;
  y->head<3>() = ldlt.solve(b.head<3>() - Nvg * y->tail<3>());
  return y->allFinite();
}

std::vector<CentreModel> centreModels(const std::vector<AlignmentFrame>& frames, const Pose& T_B_C,
                                      InertialAlignment* out, std::vector<Vec3>* dp,
                                      std::vector<Vec3>* dv, std::vector<double>* time) {
  std::vector<CentreModel> centre(frames.size());
  Quat q = Quat::Identity();
  Vec3 p = Vec3::Zero(), v = Vec3::Zero();
  double t = 0;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    if (k > 0) {
      const imu::Preintegration& link = frames[k].link;
      p += v * link.dt() + q * link.dp();
      v += q * link.dv();
      q = (q * link.dq()).normalized();
      t += link.dt();
    }
    out->q_B0_B.push_back(q);
    dp->push_back(p);
    dv->push_back(v);
    time->push_back(t);
    centre[k].C.leftCols<3>() = t * Mat3::Identity();
    centre[k].C.rightCols<3>() = 0.5 * t * t * Mat3::Identity();
    centre[k].k = p + q * T_B_C.p;
    centre[k].q_B0_C = q * T_B_C.q;
  }
  return centre;
}

}  // namespace

InertialAlignment alignInertial(const std::vector<AlignmentFrame>& frames, const Pose& T_B_C,
                                double gravity, double focal_px) {
  InertialAlignment out;
  std::vector<Vec3> dp, dv;
  std::vector<double> time;
  const std::vector<CentreModel> centre = centreModels(frames, T_B_C, &out, &dp, &dv, &time);
  std::map<std::uint64_t, std::vector<TrackSight>> tracks;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    for (const AlignmentSight& s : frames[k].sights) {
      tracks[s.id].push_back({k, centre[k].q_B0_C * s.bearing});
    }
  }
  Vec6 y = Vec6::Zero();
  // The residual is metric: far points weigh too much until depths are known, so solve again with
  // each sight divided by its depth, which makes it an angle.
  for (int round = 0; round < 4; ++round) {
    Mat6 N = Mat6::Zero();
    Vec6 b = Vec6::Zero();
    double c0 = 0;
    long used = 0;
    for (const auto& [id, sights] : tracks) {
      if (sights.size() < 3) continue;
      std::vector<double> weight(sights.size(), 1.0);
      if (round > 0) {
        const Vec3 X = pointOf(sights, centre, y);
        for (std::size_t i = 0; i < sights.size(); ++i) {
          const Vec3 d = X - (centre[sights[i].frame].C * y + centre[sights[i].frame].k);
          const double depth = std::max(0.2, d.norm());
          const double angle = d.cross(sights[i].d).norm() / depth;
          const double robust = std::min(1.0, 3.0 / focal_px / std::max(angle, 1e-9));
          weight[i] = robust / (depth * depth);
        }
      }
      addTrack(sights, centre, weight, &N, &b, &c0);
      used += static_cast<long>(sights.size());
    }
    if (used < 30) {
      out.reason = "too few tracks";
      return out;
    }
    if (!solveConstrained(N, b, gravity, &y)) {
      out.reason = "no excitation";
      return out;
    }
    const double cost = c0 - 2 * b.dot(y) + y.dot(N * y);
    out.residual_px = std::sqrt(std::max(0.0, cost) / static_cast<double>(2 * used)) * focal_px;
  }
  if (!y.allFinite() || !std::isfinite(out.residual_px)) {
    out.reason = "the sights or the readings are no numbers";
    return out;
  }
  out.g_B0 = y.tail<3>();
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const double t = time[k];
    out.p_B0.push_back(y.head<3>() * t + 0.5 * out.g_B0 * t * t + dp[k]);
    out.v_B0.push_back(y.head<3>() + out.g_B0 * t + dv[k]);
  }
  out.ok = true;
  return out;
}

}  // namespace vir::initialization
