#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "vir/initialization/inertial_alignment.h"

namespace vir::initialization {
namespace {

using Mat32d = Eigen::Matrix<double, 3, 2>;

struct Match {
  Vec3 a, b;  ///< bearings in the first and second frame, in body axes
};

struct Pair {
  Quat q;       ///< gyro's rotation, second to first, at the linearisation bias
  Mat3 J_bias;  ///< d theta / d bias
  std::vector<Match> matches;
  Vec3 t = Vec3::Zero();  ///< direction of translation, unit
};

Mat32d basisOf(const Vec3& t) {
  int axis = 0;
  t.cwiseAbs().minCoeff(&axis);
  Mat32d B;
  B.col(0) = t.cross(Vec3::Unit(axis)).normalized();
  B.col(1) = t.cross(B.col(0));
  return B;
}

std::vector<Match> matchesOf(const AlignmentFrame& f, const AlignmentFrame& g, const Quat& q_B_C) {
  std::vector<Match> out;
  std::size_t j = 0;
  for (const AlignmentSight& s : f.sights) {
    while (j < g.sights.size() && g.sights[j].id < s.id) ++j;
    if (j < g.sights.size() && g.sights[j].id == s.id) {
      out.push_back({q_B_C * s.bearing, q_B_C * g.sights[j].bearing});
    }
  }
  return out;
}

/// Direction that is most nearly orthogonal to all epipolar plane normals.
void solveDirection(Pair* p, const Quat& q) {
  Mat3 M = Mat3::Zero();
  for (const Match& m : p->matches) {
    const Vec3 n = m.a.cross(q * m.b);
    M += n * n.transpose() / (n.norm() + 1e-4);
  }
  p->t = Eigen::SelfAdjointEigenSolver<Mat3>(M).eigenvectors().col(0);
}

Pair makePair(const std::vector<AlignmentFrame>& frames, std::size_t i, std::size_t j,
              const Quat& q_B_C) {
  Pair p;
  p.q.setIdentity();
  p.J_bias.setZero();
  for (std::size_t k = i + 1; k <= j; ++k) {
    const imu::Preintegration& link = frames[k].link;
    p.J_bias = link.dq().toRotationMatrix().transpose() * p.J_bias +
               link.biasJacobian().block<3, 3>(imu::kTheta, 0);
    p.q = p.q * link.dq();
  }
  p.matches = matchesOf(frames[i], frames[j], q_B_C);
  return p;
}

std::vector<Pair> pairsOf(const std::vector<AlignmentFrame>& frames, const Quat& q_B_C) {
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    for (std::size_t step : {std::size_t{1}, std::size_t{2}, std::size_t{4}, std::size_t{8}}) {
      if (i + step >= frames.size()) break;
      Pair p = makePair(frames, i, i + step, q_B_C);
      if (p.matches.size() >= 10) pairs.push_back(std::move(p));
    }
  }
  return pairs;
}

/// The normal equations of the bias, and the weighted squares they leave.
struct BiasEquations {
  Mat3 H = Mat3::Zero();
  Vec3 g = Vec3::Zero();
  double sum = 0;
  long count = 0;

  /// `q`: rotation of the pair with the bias as it is; beyond `huber` [rad] a sight weighs less.
  void add(const Pair& p, const Quat& q, double huber) {
    const Mat3 R = q.toRotationMatrix();
    const Mat32d B = basisOf(p.t);
    Eigen::Matrix<double, 5, 5> N = Eigen::Matrix<double, 5, 5>::Zero();
    Eigen::Matrix<double, 5, 1> y = Eigen::Matrix<double, 5, 1>::Zero();
    for (const Match& m : p.matches) {
      const Vec3 Rb = R * m.b;
      const Vec3 n = m.a.cross(Rb);
      const double r = p.t.dot(n);
      Eigen::Matrix<double, 1, 5> J;
      J.head<3>() = -(p.t.cross(m.a)).transpose() * R * hat(m.b) * p.J_bias;
      J.tail<2>() = (B.transpose() * n).transpose();
      const double w = std::abs(r) > huber ? huber / std::abs(r) : 1.0;
      N += w * J.transpose() * J;
      y += w * J.transpose() * r;
      sum += w * r * r;
      ++count;
    }
    // The direction is this pair's own unknown; a little damping where there is no parallax.
    const Eigen::Matrix2d D =
        N.bottomRightCorner<2, 2>() +
        1e-8 * static_cast<double>(p.matches.size()) * Eigen::Matrix2d::Identity();
    const Eigen::Matrix<double, 3, 2> W = N.topRightCorner<3, 2>() * D.inverse();
    H += N.topLeftCorner<3, 3>() - W * N.bottomLeftCorner<2, 3>();
    g += y.head<3>() - W * y.tail<2>();
  }
};

}  // namespace

GyroBiasEstimate estimateGyroBias(const std::vector<AlignmentFrame>& frames, const Quat& q_B_C,
                                  double focal_px, const Vec3& start) {
  GyroBiasEstimate out;
  std::vector<Pair> pairs = pairsOf(frames, q_B_C);
  out.pairs = static_cast<int>(pairs.size());
  if (pairs.empty()) {
    out.reason = "too few tracks";
    return out;
  }
  const Vec3 b0 = frames.size() > 1 ? frames[1].link.biasGyro() : Vec3::Zero();
  Vec3 bias = start;
  const auto rotation = [&](const Pair& p) { return p.q * expQuat(p.J_bias * (bias - b0)); };
  for (Pair& p : pairs) solveDirection(&p, rotation(p));
  const double huber = 1.0 / focal_px;
  for (int iteration = 0; iteration < 12; ++iteration) {
    BiasEquations equations;
    for (const Pair& p : pairs) equations.add(p, rotation(p), huber);
    const auto& [H, g, sum, count] = equations;
    const Vec3 step = -(H + 1e-12 * H.trace() * Mat3::Identity()).ldlt().solve(g);
    if (!step.allFinite()) {
      out.reason = "singular";
      return out;
    }
    bias += step.norm() > 0.1 ? Vec3(0.1 * step.normalized()) : step;
    out.rms_px = std::sqrt(sum / static_cast<double>(std::max<long>(1, count))) * focal_px;
    for (Pair& p : pairs) solveDirection(&p, rotation(p));
  }
  out.bias = bias;
  out.ok = bias.norm() < 1.0 && std::isfinite(out.rms_px);
  if (!out.ok) out.reason = "implausible gyro bias";
  return out;
}

}  // namespace vir::initialization
