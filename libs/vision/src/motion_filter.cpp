#include "motion_filter.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "vir/core/order_statistics.h"

namespace vir::vision {

namespace {

constexpr int kHypotheses = 48;
constexpr double kStillPx = 0.5;  // 90 % of the tracks moving less than this is no parallax
constexpr std::size_t kMinForRotation = 8;

using Mat32 = Eigen::Matrix<double, 3, 2>;

/// Displacement [px] in the current image that a rotation alone does not explain.
Vec2 compensatedFlow(const BearingPair& p, const Mat3& R) {
  return p.J1 * (p.b1 - R.transpose() * p.b0);
}

/// Small deterministic generator: the same on every platform, unlike std distributions.
class Random {
 public:
  std::size_t below(std::size_t n) {
    state_ = state_ * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<std::size_t>((state_ >> 33) % n);
  }

 private:
  std::uint64_t state_ = 0x853c49e6748fea9bULL;
};

/// Epipolar geometry of one pair for a given rotation: the signed distance from the epipolar line
/// in the current image is n.t / |G t| for the unit direction t.
struct Line {
  Vec3 n;
  Mat23 G;
};

class MotionFit {
 public:
  MotionFit(const std::vector<BearingPair>& pairs, const Mat3& R_C0_C1, double sigma, double limit)
      : pairs_(pairs), R0_(R_C0_C1), sigma_(sigma), limit_(limit), inverse_(pairs.size()) {
    // d bearing / d px: the pseudo-inverse of the projection Jacobian (bearings have unit length).
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const Mat23& J = pairs[i].J1;
      inverse_[i] = J.transpose() * (J * J.transpose()).inverse();
    }
  }

  Mat3 rotation(const Vec3& delta) const { return R0_ * expSO3(delta); }

  /// The rotation alone that most tracks agree with (reweighted least squares, Cauchy).
  Vec3 fitRotation() const {
    Vec3 delta = Vec3::Zero();
    double scale = 8.0;
    for (int iteration = 0; iteration < 8; ++iteration) {
      const Mat3 R = rotation(delta);
      Mat3 H = Mat3::Identity() * 1e-6;
      Vec3 g = Vec3::Zero();
      for (const BearingPair& p : pairs_) {
        const Vec2 r = -compensatedFlow(p, R);
        const Mat23 A = -p.J1 * hat(p.b1);
        const double w = 1.0 / (1.0 + r.squaredNorm() / (scale * scale));
        H += w * A.transpose() * A;
        g += w * A.transpose() * r;
      }
      delta = logSO3(expSO3(delta) * expSO3(H.ldlt().solve(g)));
      scale = std::max(1.0, 0.6 * scale);
    }
    return delta;
  }

  void setRotation(const Vec3& delta) {
    const Mat3 R = rotation(delta);
    lines_.resize(pairs_.size());
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      lines_[i].n = pairs_[i].b0.cross(R * pairs_[i].b1);
      lines_[i].G = -inverse_[i].transpose() * R.transpose() * hat(pairs_[i].b0);
    }
  }

  double squaredDistance(std::size_t i, const Vec3& t) const {
    const double e = lines_[i].n.dot(t);
    return e * e / ((lines_[i].G * t).squaredNorm() + 1e-12);
  }

  double cost(const Vec3& t) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < lines_.size(); ++i) {
      sum += std::min(squaredDistance(i, t), limit_ * limit_);
    }
    return sum;
  }

  /// Two-point RANSAC for the direction at the rotation last set.
  Vec3 sampleDirection() const {
    Random random;
    Vec3 best = Vec3::UnitZ();
    double best_cost = cost(best);
    for (int k = 0; k < kHypotheses; ++k) {
      const std::size_t a = random.below(lines_.size());
      const std::size_t b = random.below(lines_.size());
      const Vec3 t = lines_[a].n.cross(lines_[b].n);
      const double length = t.norm();
      if (a == b || !(length > 1e-12)) continue;
      const double c = cost(t / length);
      if (c < best_cost) {
        best_cost = c;
        best = t / length;
      }
    }
    return best;
  }

  /// Gauss-Newton over direction and rotation together, with outliers weighted down. Leaves the
  /// rotation set and returns the cost.
  double refine(Vec3* delta, Vec3* t) {
    using Mat5 = Eigen::Matrix<double, 5, 5>;
    using Vec5 = Eigen::Matrix<double, 5, 1>;
    setRotation(*delta);
    double best = cost(*t);
    for (int iteration = 0; iteration < 5; ++iteration) {
      const Mat3 R = rotation(*delta);
      const Vec3 e1 = t->unitOrthogonal();
      const Vec3 e2 = t->cross(e1);
      Mat5 H = Mat5::Identity() * 1e-6;
      Vec5 g = Vec5::Zero();
      const double prior = 1.0 / (sigma_ * sigma_);
      H.diagonal().head<3>().array() += prior;
      g.head<3>() -= prior * *delta;
      for (std::size_t i = 0; i < pairs_.size(); ++i) {
        const double scale = 1.0 / std::sqrt((lines_[i].G * *t).squaredNorm() + 1e-12);
        const double r = lines_[i].n.dot(*t) * scale;
        const double ratio = r / (0.5 * limit_);
        const double w = 1.0 / ((1.0 + ratio * ratio) * (1.0 + ratio * ratio));
        Vec5 J;
        J.head<3>() = scale * (R * hat(pairs_[i].b1)).transpose() * -t->cross(pairs_[i].b0);
        J[3] = scale * lines_[i].n.dot(e1);
        J[4] = scale * lines_[i].n.dot(e2);
        H += w * J * J.transpose();
        g -= w * r * J;
      }
      const Vec5 step = H.ldlt().solve(g);
      if (!step.allFinite()) break;
      const Vec3 new_delta = *delta + step.head<3>();
      const Vec3 new_t = (*t + step[3] * e1 + step[4] * e2).normalized();
      setRotation(new_delta);
      const double c = cost(new_t);
      if (!(c < best)) {
        setRotation(*delta);
        break;
      }
      best = c;
      *delta = new_delta;
      *t = new_t;
    }
    return best;
  }

 private:
  const std::vector<BearingPair>& pairs_;
  Mat3 R0_;
  double sigma_, limit_;
  std::vector<Mat32> inverse_;
  std::vector<Line> lines_;
};

/// Displacement along the epipolar line [px]; positive for points in front when `t` has the right
/// sign. 0 near the epipole, where it says nothing.
double forwardParallax(const BearingPair& p, const Mat3& R, const Vec3& t) {
  const Vec2 along = -(p.J1 * (R.transpose() * t));
  const double length = along.norm();
  if (!(length > 1.0)) return 0.0;
  return compensatedFlow(p, R).dot(along) / length;
}

}  // namespace

MotionVerdict filterByMotion(const std::vector<BearingPair>& pairs, const Mat3& R_C0_C1,
                             double rotation_sigma, double threshold_px) {
  MotionVerdict verdict;
  verdict.inlier.assign(pairs.size(), 1);
  if (pairs.size() < 3) return verdict;
  const bool enough = pairs.size() >= kMinForRotation;
  MotionFit fit(pairs, R_C0_C1, rotation_sigma, threshold_px);

  const Vec3 rotation_only = enough ? fit.fitRotation() : Vec3::Zero();
  const Mat3 R_still = fit.rotation(rotation_only);
  std::vector<double> flow;
  for (const BearingPair& p : pairs) flow.push_back(compensatedFlow(p, R_still).norm());
  std::vector<double> ranked = flow;
  if (quantileInPlace(&ranked, 0.9) < kStillPx) {
    for (std::size_t i = 0; i < pairs.size(); ++i) verdict.inlier[i] = flow[i] < threshold_px;
    verdict.rotation_correction = rotation_only;
    return verdict;
  }

  // The gyro's rotation may carry a bias; the rotation fitted to the tracks may have swallowed
  // translation. Start from both and let the tracks decide.
  Vec3 delta = Vec3::Zero();
  fit.setRotation(delta);
  Vec3 t = fit.sampleDirection();
  if (enough) {
    const double cost = fit.refine(&delta, &t);
    Vec3 other_delta = rotation_only;
    fit.setRotation(other_delta);
    Vec3 other_t = fit.sampleDirection();
    if (fit.refine(&other_delta, &other_t) < cost) {
      delta = other_delta;
      t = other_t;
    }
    fit.setRotation(delta);
  }

  const Mat3 R = fit.rotation(delta);
  double vote = 0.0;
  for (const BearingPair& p : pairs) {
    vote += std::clamp(forwardParallax(p, R, t), -threshold_px, threshold_px);
  }
  if (vote < 0.0) t = -t;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    verdict.inlier[i] = fit.squaredDistance(i, t) < threshold_px * threshold_px &&
                        forwardParallax(pairs[i], R, t) > -threshold_px;
  }
  verdict.rotation_correction = delta;
  verdict.direction = t;
  return verdict;
}

}  // namespace vir::vision
