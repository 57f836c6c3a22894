#pragma once
/// Does a covariance tell the truth? Normalised estimation error squared.
#include <Eigen/Core>
#include <vector>

#include "vir/geometry/pose.h"

namespace vir::evaluation {

/// e^T P^-1 e. False (and `*value` = 0) when `P` is not positive definite or anything is not
/// finite: such a covariance makes no statement that could be tested.
bool nees(const Eigen::VectorXd& error, const Eigen::MatrixXd& covariance, double* value);

/// Error of an estimate in the order of StateEstimate::covariance: position in W [m], then rotation
/// on the right [rad]: R_est = R_ref Exp(e).
Eigen::Matrix<double, 6, 1> poseError(const Pose& T_W_B_reference, const Pose& T_W_B_estimate);

/// Position and yaw only: T_R_E that lays an estimated pose T_E_B onto the true one T_R_B, the
/// world that an estimator without absolute measurements starts in. Well defined whatever axis of
/// the body points up.
Pose gaugeAt(const Pose& T_R_B, const Pose& T_E_B);

/// Value that a chi-square variable of `dof` degrees stays below with probability `p` (0 < p < 1);
/// throws std::invalid_argument for others. Absolute error below 1e-9 of the value.
double chiSquareQuantile(int dof, double p);

struct NeesSummary {
  long count = 0;
  double mean_per_dof = 0;    ///< 1 = consistent, above = too sure of itself
  double share_below_95 = 0;  ///< share of values below the 95 % quantile; 0.95 = consistent
};

/// `values` of `dof` degrees each.
NeesSummary summariseNees(const std::vector<double>& values, int dof);

}  // namespace vir::evaluation
