#include "evidence_cost.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace vir::team {
namespace {

constexpr double kMinVariance = 1e-12;  // [m^2], of an anchor that is said to be exact
constexpr double kMinDistance = 1e-9;   // closer than this a range has no direction

/// L^T u with L L^T = C, for any symmetric C without negative eigenvalues, up to rounding.
Vec3 rootTimes(const Mat3& C, const Vec3& u) {
  const auto root = [](double d) { return d > 1e-15 ? std::sqrt(d) : 0.0; };
  const auto share = [](double c, double l) { return l > 0 ? c / l : 0.0; };
  const double l00 = root(C(0, 0));
  const double l10 = share(C(1, 0), l00), l20 = share(C(2, 0), l00);
  const double l11 = root(C(1, 1) - l10 * l10);
  const double l21 = share(C(2, 1) - l20 * l10, l11);
  const double l22 = root(C(2, 2) - l20 * l20 - l21 * l21);
  return {l00 * u.x() + l10 * u.y() + l20 * u.z(), l11 * u.y() + l21 * u.z(), l22 * u.z()};
}

/// Sum of logarithms, taken once in a while.
class LogSum {
 public:
  void add(double factor) {
    product_ *= factor;
    if (!(product_ > 1e-200 && product_ < 1e200)) {
      sum_ += std::log(product_);
      product_ = 1;
    }
  }
  double value() const { return sum_ + std::log(product_); }

 private:
  double sum_ = 0, product_ = 1;
};

/// The errors that ranges share, as a Kalman filter over the ranges: covariance of the state
/// (position error in its own units, slow error in sigmas, drift since then in its own), and the
/// means of residual and Jacobian.
template <int kStates, int kColumns>
struct SharedErrors {
  using State = Eigen::Matrix<double, kStates, 1>;
  Eigen::Matrix<double, kStates, kStates> P = Eigen::Matrix<double, kStates, kStates>::Zero();
  Eigen::Matrix<double, kStates, kColumns> mean = Eigen::Matrix<double, kStates, kColumns>::Zero();
  State phi = State::Ones();

  SharedErrors() { P.template topLeftCorner<4, 4>().setIdentity(); }

  /// To a range `dt_s` away, over which so much of the errors stays.
  void predict(double phi_position, double phi_range, double dt_s) {
    phi.template head<4>() << phi_position, phi_position, phi_position, phi_range;
    P.array() *= (phi * phi.transpose()).array();
    P.diagonal() += State::Ones() - phi.cwiseProduct(phi);
    mean.array().colwise() *= phi.array();
    if constexpr (kStates > 4) P.diagonal().template tail<4>().array() += dt_s;
  }

  /// By a range: `Ph` is P times its sensitivity, `row` what the means did not foresee.
  void correct(const State& Ph, double gain, const Eigen::Matrix<double, 1, kColumns>& row) {
    mean.noalias() += (gain * Ph) * row;
    P.noalias() -= (gain * Ph) * Ph.transpose();
  }
};

}  // namespace

Vec4 toVector(const WorldTransform& T) { return {T.yaw_rad, T.t_m.x(), T.t_m.y(), T.t_m.z()}; }
WorldTransform fromVector(const Vec4& x) { return {wrapAngle(x[0]), x.tail<3>()}; }

Mat3x4 pointJacobian(const Vec3& rotated_p) {
  Mat3x4 J;
  J.col(0) = Vec3(-rotated_p.y(), rotated_p.x(), 0);
  J.rightCols<3>().setIdentity();
  return J;
}

EvidenceCost::EvidenceCost(const std::vector<MutualRange>& ranges,
                           const std::vector<SharedAnchor>& anchors,
                           const TransformOptions& options, double position_share,
                           const std::optional<SharedPlaces>& places)
    : ranges_(ranges),
      anchors_(anchors),
      options_(options),
      position_share_(position_share),
      drift_(options.drift_m_per_sqrt_s > 0 || options.drift_rad_per_sqrt_s > 0) {
  if (places) {
    const TimeNs newest = ranges.empty() ? places->until : ranges.back().t;
    places_ = PlacesCost(*places, options, toSeconds(newest - places->until));
  }
  steps_.reserve(ranges.size());
  for (std::size_t k = 0; k < ranges.size(); ++k) {
    const bool newest = k + 1 == ranges.size();
    const double dt = newest ? 0 : std::max(0.0, toSeconds(ranges[k + 1].t - ranges[k].t));
    steps_.push_back({std::exp(-dt / options.position_time_s), std::exp(-dt / options.slow_time_s),
                      dt, ranges[k].cov_A.isZero(0) && ranges[k].cov_B.isZero(0)});
  }
}

double EvidenceCost::anchorChi2(const SharedAnchor& a, const Vec4& x) const {
  const Mat3 R = rotZ(x[0]);
  Mat3 C = a.cov_A + R * a.cov_B * R.transpose();
  C.diagonal().array() += kMinVariance;
  const Vec3 e = a.p_A - R * a.p_B - x.tail<3>();
  return e.dot(C.ldlt().solve(e));
}

int EvidenceCost::anchorsUsed(const Vec4& x) const {
  return static_cast<int>(std::count_if(
      anchors_.begin(), anchors_.end(),
      [&](const SharedAnchor& a) { return anchorChi2(a, x) < options_.anchor_chi2; }));
}

double EvidenceCost::addAnchors(const Vec4& x, const Mat3& R, Mat4* H, Vec4* g) const {
  double cost = 0;
  for (const SharedAnchor& a : anchors_) {
    Mat3 C = a.cov_A + R * a.cov_B * R.transpose();
    C.diagonal().array() += kMinVariance;
    const Vec3 rotated = R * a.p_B;
    const Vec3 e = a.p_A - rotated - x.tail<3>();
    const Mat3 W = C.inverse();
    const double chi2 = e.dot(W * e);
    // A wrong anchor costs so much and pulls no more.
    if (!(chi2 < options_.anchor_chi2)) {
      cost += options_.anchor_chi2;
      continue;
    }
    cost += chi2;
    if (H == nullptr) continue;
    const Mat3x4 J = -pointJacobian(rotated);
    *H += J.transpose() * W * J;
    *g += J.transpose() * (W * e);
  }
  return cost;
}

EvidenceCost::Weighed EvidenceCost::weigh(double r) const {
  // The loss of RobustRange, with the logarithms gathered.
  const double huber = options_.robust.huber_delta, nlos = options_.robust.nlos_delta;
  if (r < 0 && huber > 0) {
    const double root = std::sqrt(1 + r * r / (huber * huber));
    return {2 * huber * huber * (root - 1), 1 / root, 1};
  }
  if (r > 0 && nlos > 0) {
    const double tail = 1 + r * r / (nlos * nlos);
    return {0, 1 / tail, tail};
  }
  return {r * r, 1, 1};
}

template <int kStates>
void EvidenceCost::sensitivity(std::size_t k, const Mat3& R, const Sight& sight,
                               Eigen::Matrix<double, kStates, 1>* h) const {
  const MutualRange& m = ranges_[k];
  const Vec3& u = sight.direction;
  h->template head<3>().setZero();
  if (!steps_[k].exact) {
    Mat3 C = m.cov_A;
    C.noalias() += R * (m.cov_B * R.transpose());
    h->template head<3>() = position_share_ * rootTimes(C, u);
  }
  (*h)[3] = options_.slow_share * m.sigma_m;
  if constexpr (kStates > 4) {
    const Vec3 arm = sight.rotated_p_B - R * ranges_.back().p_B;
    h->template tail<4>() << options_.drift_m_per_sqrt_s * u,
        options_.drift_rad_per_sqrt_s * (u.y() * arm.x() - u.x() * arm.y());
  }
}

template <int kStates, int kColumns>
double EvidenceCost::pass(const Vec4& x, Mat4* H, Vec4* g,
                          std::vector<Innovation>* innovations) const {
  constexpr bool kLinear = kColumns > 1;
  using State = Eigen::Matrix<double, kStates, 1>;
  const Mat3 R = rotZ(x[0]);
  const Vec3 t = x.tail<3>();
  if (kLinear) {
    H->setZero();
    g->setZero();
  }
  double cost = addAnchors(x, R, H, g) + places_.add(x, H, g);
  if (ranges_.empty()) return cost;
  LogSum variances, tails;
  SharedErrors<kStates, kColumns> errors;
  State h;
  for (std::size_t k = ranges_.size(); k-- > 0;) {
    const MutualRange& m = ranges_[k];
    const Step& step = steps_[k];
    errors.predict(step.phi_position, step.phi_range, step.dt_s);
    const Vec3 rotated = R * m.p_B;
    const Vec3 v = m.p_A - rotated - t;
    const double distance = v.norm();
    const Vec3 u = distance > kMinDistance ? Vec3(v / distance) : Vec3(Vec3::Zero());
    sensitivity<kStates>(k, R, {u, rotated}, &h);
    const State Ph = errors.P * h;
    const double variance = m.sigma_m * m.sigma_m;
    const double S = h.dot(Ph) + variance;
    Eigen::Matrix<double, 1, kColumns> row;
    row[0] = m.range_m - distance;
    if constexpr (kLinear) {
      row.template tail<4>() << u.y() * rotated.x() - u.x() * rotated.y(), u.x(), u.y(), u.z();
    }
    row.noalias() -= h.transpose() * errors.mean;

    const double r = row[0] / std::sqrt(S);
    const Weighed weighed = weigh(r);
    cost += weighed.cost;
    if (weighed.tail != 1) tails.add(weighed.tail);
    variances.add(S / variance);
    const double gain = weighed.weight / S;
    if constexpr (kLinear) {
      const Eigen::Matrix<double, 1, 4> J = row.template tail<4>();
      H->noalias() += (gain * J.transpose()) * J;
      *g += (gain * row[0]) * J.transpose();
    }
    if (innovations != nullptr) innovations->push_back({r, m.range_m - distance});
    errors.correct(Ph, gain, row);
  }
  const double nlos = options_.robust.nlos_delta;
  return cost + variances.value() + nlos * nlos * tails.value();
}

double EvidenceCost::operator()(const Vec4& x) const {
  return drift_ ? pass<8, 1>(x, nullptr, nullptr, nullptr)
                : pass<4, 1>(x, nullptr, nullptr, nullptr);
}

double EvidenceCost::linearise(const Vec4& x, Mat4* H, Vec4* g) const {
  return drift_ ? pass<8, 5>(x, H, g, nullptr) : pass<4, 5>(x, H, g, nullptr);
}

std::vector<Innovation> EvidenceCost::innovations(const Vec4& x) const {
  std::vector<Innovation> out;
  out.reserve(ranges_.size());
  drift_ ? pass<8, 1>(x, nullptr, nullptr, &out) : pass<4, 1>(x, nullptr, nullptr, &out);
  return out;
}

double descend(const EvidenceCost& cost, Vec4* x, const Descent& how) {
  // Most steps are taken: derivatives are made with the value, so that one pass does for both.
  Mat4 H, next_H;
  Vec4 g, next_g;
  double now = cost.linearise(*x, &H, &g);
  double lambda = 1e-4;
  for (int i = 0; i < how.iterations; ++i) {
    if (how.held != nullptr) {
      const Mat4 along = *how.held * how.held->transpose(), rest = Mat4::Identity() - along;
      H = rest * H * rest + H.trace() * along;
      g = rest * g;
    }
    Mat4 damped = H;
    // The absolute part (per m^2, per rad^2) holds directions that the evidence leaves open.
    damped.diagonal() += lambda * (H.diagonal() + Vec4::Ones()) + Vec4::Constant(1e-9);
    const Vec4 step = -damped.ldlt().solve(g);
    if (!step.allFinite()) break;
    const Vec4 next = *x + step;
    const double then = cost.linearise(next, &next_H, &next_g);
    const bool small =
        step.squaredNorm() < 1e-20 || std::abs(now - then) < how.tolerance * (1 + std::abs(now));
    if (then <= now) {
      *x = next;
      lambda = std::max(lambda * 0.1, 1e-12);
      if (small) return then;
      now = then;
      H = next_H;
      g = next_g;
    } else {
      if (small || lambda > 1e8) break;
      lambda = std::max(lambda * 8, 1e-6);
    }
  }
  return now;
}

}  // namespace vir::team
