/// Which offset of the clocks, and which rotation of the camera, makes gyro and images agree.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "vir/core/order_statistics.h"
#include "vir/initialization/image_turn.h"

namespace vir::initialization {
namespace {

constexpr int kFewestTurns = 8;
/// An answer must be this much better than any other that is further off than kApartS
/// (squared whitened residuals).
constexpr double kClearly = 12;
constexpr double kApartS = 0.015;
constexpr double kEnoughSigmaS = 0.012;
constexpr double kEnoughExplained = 0.6;

/// How many turns the overlapping ones are worth.
double independent(const std::vector<ImageTurn>& turns) {
  double sum = 0;
  for (const ImageTurn& turn : turns) sum += toSeconds(turn.t1 - turn.t0);
  const double covered = toSeconds(turns.back().t1 - turns.front().t0);
  return static_cast<double>(turns.size()) * std::min(1.0, covered / std::max(1e-9, sum));
}

/// Turns and what the gyro says of the same stretch of time.
struct Matched {
  std::vector<Vec3> image, gyro;  ///< [rad/s]; `image` in the camera's axes
  std::vector<Mat3> information;  ///< of `image`, in the camera's axes
};

Matched matchAt(const std::vector<ImageTurn>& turns, const imu::ImuBuffer& imu, double offset_s) {
  Matched out;
  const TimeNs shift = fromSeconds(offset_s);
  for (const ImageTurn& turn : turns) {
    Vec3 rate;
    if (!imu.meanGyro(turn.t0 + shift, turn.t1 + shift, &rate)) continue;
    out.image.push_back(turn.rate_C);
    out.gyro.push_back(rate);
    out.information.push_back(turn.information);
  }
  return out;
}

/// Robust weighted least squares of image = R^T (gyro - bias), the bias being free.
struct Fit {
  double cost = 0;         ///< squared residuals, weighted, per turn
  double unexplained = 0;  ///< the same if the images said nothing but their mean
  Vec3 bias = Vec3::Zero();
  std::vector<double> weight;
  int turns = 0;
};

Fit fitBias(const Matched& m, const Mat3& R_B_C, double scale) {
  Fit out;
  out.turns = static_cast<int>(m.image.size());
  out.weight.assign(m.image.size(), 1.0);
  Vec3 mean = Vec3::Zero();
  for (int round = 0; round < 4; ++round) {
    Mat3 H = Mat3::Zero();
    Vec3 g = Vec3::Zero(), gm = Vec3::Zero();
    for (std::size_t k = 0; k < m.image.size(); ++k) {
      const Mat3 W = out.weight[k] * R_B_C * m.information[k] * R_B_C.transpose();
      H += W;
      g += W * (m.gyro[k] - R_B_C * m.image[k]);
      gm += W * m.gyro[k];
    }
    const Mat3 inverse = (H + 1e-9 * (H.trace() + 1e-12) * Mat3::Identity()).inverse();
    out.bias = inverse * g;
    mean = inverse * gm;
    out.cost = out.unexplained = 0;
    for (std::size_t k = 0; k < m.image.size(); ++k) {
      const Vec3 r = R_B_C.transpose() * (m.gyro[k] - out.bias) - m.image[k];
      const Vec3 v = R_B_C.transpose() * (m.gyro[k] - mean);
      const double squared = r.dot(m.information[k] * r);
      out.cost += scale * scale * std::log1p(squared / (scale * scale));
      out.unexplained += scale * scale * std::log1p(v.dot(m.information[k] * v) / (scale * scale));
      out.weight[k] = 1 / (1 + squared / (scale * scale));
    }
  }
  if (out.turns > 0) {
    out.cost /= out.turns;
    out.unexplained /= out.turns;
  }
  return out;
}

/// Robust size of a whitened residual, from the fit at a first guess of the offset.
double residualScale(const Matched& m, const Mat3& R_B_C) {
  if (m.image.empty()) return 1;
  const Fit f = fitBias(m, R_B_C, 1e3);
  std::vector<double> size;
  for (std::size_t k = 0; k < m.image.size(); ++k) {
    const Vec3 r = R_B_C.transpose() * (m.gyro[k] - f.bias) - m.image[k];
    size.push_back(std::sqrt(r.dot(m.information[k] * r)));
  }
  return std::max(0.3, 2.0 * medianInPlace(&size));
}

struct Curve {
  std::vector<double> offset, cost, unexplained;
  std::size_t best = 0;
  bool inside() const { return best > 0 && best + 1 < cost.size(); }
};

Curve curveOf(const std::vector<ImageTurn>& turns, const imu::ImuBuffer& imu, const Mat3& R_B_C,
              const TurnSearch& search, double scale) {
  Curve out;
  const int n = static_cast<int>(std::floor(search.max_offset_s / search.step_s + 1e-9));
  for (int k = -n; k <= n; ++k) {
    const double offset = k * search.step_s;
    const Matched m = matchAt(turns, imu, offset);
    if (static_cast<int>(m.image.size()) <
        std::max<int>(kFewestTurns, static_cast<int>(turns.size()) * 6 / 10)) {
      continue;
    }
    const Fit f = fitBias(m, R_B_C, scale);
    out.offset.push_back(offset);
    out.cost.push_back(f.cost);
    out.unexplained.push_back(f.unexplained);
    if (f.cost < out.cost[out.best]) out.best = out.cost.size() - 1;
  }
  return out;
}

double costAt(const std::vector<ImageTurn>& turns, const imu::ImuBuffer& imu, const Mat3& R_B_C,
              double scale, double offset) {
  return fitBias(matchAt(turns, imu, offset), R_B_C, scale).cost;
}

}  // namespace

TurnCorrelation correlateTurns(const std::vector<ImageTurn>& turns, const imu::ImuBuffer& imu,
                               const Quat& q_B_C, const TurnSearch& search) {
  TurnCorrelation out;
  out.turns = static_cast<int>(turns.size());
  if (out.turns < kFewestTurns) {
    out.reason = "too few images";
    return out;
  }
  const Mat3 R = q_B_C.toRotationMatrix();
  double scale = 1e3;
  Curve curve = curveOf(turns, imu, R, search, scale);
  if (curve.cost.size() < 3) {
    out.reason = "too few readings";
    return out;
  }
  scale = residualScale(matchAt(turns, imu, curve.offset[curve.best]), R);
  curve = curveOf(turns, imu, R, search, scale);
  const double n = independent(turns);
  // Noise from what is left at the best offset; 3 numbers a turn, 4 of all estimated.
  const double variance = std::max(1e-4, curve.cost[curve.best] * n / std::max(1.0, 3 * n - 4));
  out.explained = 1 - curve.cost[curve.best] / std::max(1e-12, curve.unexplained[curve.best]);
  if (!curve.inside()) {
    out.reason = "no offset within reach fits";
    return out;
  }
  // A parabola through three points around the minimum.
  const double h = search.step_s, x = curve.offset[curve.best];
  const double low = costAt(turns, imu, R, scale, x - h), mid = curve.cost[curve.best],
               high = costAt(turns, imu, R, scale, x + h);
  const double curvature = (low + high - 2 * mid) / (h * h);
  if (!(curvature > 0)) {
    out.reason = "too little turning";
    return out;
  }
  out.offset_s = x - std::clamp(0.5 * (high - low) / (h * curvature), -h, h);
  out.sigma_s = std::sqrt(variance / (0.5 * curvature * n));
  out.gyro_bias = fitBias(matchAt(turns, imu, out.offset_s), R, scale).bias;
  out.against_none = (costAt(turns, imu, R, scale, 0) - mid) * n / variance;
  if (out.sigma_s > kEnoughSigmaS || out.explained < kEnoughExplained) {
    out.reason = "too little turning";
    return out;
  }
  for (std::size_t k = 0; k < curve.cost.size(); ++k) {
    const bool apart = std::abs(curve.offset[k] - out.offset_s) > kApartS;
    if (apart && (curve.cost[k] - mid) * n / variance < kClearly) {
      out.reason = "several offsets fit";
      return out;
    }
  }
  out.ok = true;
  return out;
}

CameraRotation findCameraRotation(const std::vector<ImageTurn>& turns, const imu::ImuBuffer& imu,
                                  const TurnSearch& search) {
  CameraRotation best;
  const int n = static_cast<int>(std::floor(search.max_offset_s / search.step_s + 1e-9));
  for (int k = -n; k <= n; ++k) {
    const Matched m = matchAt(turns, imu, k * search.step_s);
    const double count = static_cast<double>(m.image.size());
    if (count < kFewestTurns || count < 0.6 * static_cast<double>(turns.size())) continue;
    // Both without their means, which takes the gyro's bias out.
    Vec3 image = Vec3::Zero(), gyro = Vec3::Zero();
    for (std::size_t i = 0; i < m.image.size(); ++i) {
      image += m.image[i] / count;
      gyro += m.gyro[i] / count;
    }
    Mat3 M = Mat3::Zero();
    double total = 0;
    for (std::size_t i = 0; i < m.image.size(); ++i) {
      M += (m.image[i] - image) * (m.gyro[i] - gyro).transpose();
      total += (m.gyro[i] - gyro).squaredNorm();
    }
    const Eigen::JacobiSVD<Mat3> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Mat3 S = Mat3::Identity();
    S(2, 2) = (svd.matrixV() * svd.matrixU().transpose()).determinant();
    const Mat3 R = svd.matrixV() * S * svd.matrixU().transpose();
    double left = 0;
    for (std::size_t i = 0; i < m.image.size(); ++i) {
      left += ((m.gyro[i] - gyro) - R * (m.image[i] - image)).squaredNorm();
    }
    const double explained = 1 - left / std::max(1e-12, total);
    if (explained <= best.explained) continue;
    best.explained = explained;
    best.q_B_C = Quat(R).normalized();
    best.offset_s = k * search.step_s;
    // What the least excited pair of axes says of the rotation about the third.
    const double strength = svd.singularValues()[1] + svd.singularValues()[2];
    best.sigma_rad = std::sqrt(left / std::max(1.0, 3 * count - 7) / std::max(1e-12, strength));
  }
  best.ok = best.explained > 0.8 && best.sigma_rad < 0.05;
  return best;
}

}  // namespace vir::initialization
