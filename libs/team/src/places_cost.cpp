#include "places_cost.h"

#include <Eigen/LU>
#include <cmath>

#include "evidence_cost.h"

namespace vir::team {

PlacesCost::PlacesCost(const SharedPlaces& shared, const TransformOptions& options, double since_s)
    : T_A_B_(shared.T_A_B),
      centre_A_(shared.T_A_B * shared.centre_B),
      centre_B_(shared.centre_B),
      limit_(options.places_chi2),
      given_(true) {
  // About the places' middle yaw and offset are hardly correlated.
  Mat4 to_centre = Mat4::Zero();
  to_centre(0, 0) = 1;
  to_centre.bottomRows<3>() = pointJacobian(centre_A_ - shared.T_A_B.t_m);
  Mat4 C = to_centre * shared.covariance * to_centre.transpose();
  const double dt = std::max(0.0, since_s);
  C(0, 0) += options.drift_rad_per_sqrt_s * options.drift_rad_per_sqrt_s * dt;
  C.diagonal().tail<3>().array() += options.drift_m_per_sqrt_s * options.drift_m_per_sqrt_s * dt;
  information_ = C.inverse();
}

Vec4 PlacesCost::error(const Vec4& x) const {
  Vec4 e;
  e << wrapAngle(x[0] - T_A_B_.yaw_rad), rotZ(x[0]) * centre_B_ + x.tail<3>() - centre_A_;
  return e;
}

double PlacesCost::chi2(const Vec4& x) const {
  const Vec4 e = error(x);
  return e.dot(information_ * e);
}

double PlacesCost::add(const Vec4& x, Mat4* H, Vec4* g) const {
  if (!given_) return 0;
  const Vec4 e = error(x);
  const double chi2 = e.dot(information_ * e);
  if (!(chi2 < limit_)) return limit_;
  if (H == nullptr) return chi2;
  Mat4 J = Mat4::Zero();
  J(0, 0) = 1;
  J.bottomRows<3>() = pointJacobian(rotZ(x[0]) * centre_B_);
  *H += J.transpose() * information_ * J;
  *g += J.transpose() * (information_ * e);
  return chi2;
}

}  // namespace vir::team
