#pragma once
/// Does a covariance tell the truth? Normalised estimation error squared.
#include <Eigen/Core>
#include <vector>

#include "vir/geometry/pose.h"

namespace vir::evaluation {

/// e^T P^-1 e. False (and `*value` = 0) when `P` is not positive definite or anything is not
/// finite: such a covariance makes no statement that could be tested.
bool nees(const Eigen::VectorXd& error, const Eigen::MatrixXd& covariance, double* value);

/// Position and yaw only: T_R_E that lays an estimated pose T_E_B onto the true one T_R_B, the
/// world that an estimator without absolute measurements starts in. Well defined whatever axis of
/// the body points up.
Pose gaugeAt(const Pose& T_R_B, const Pose& T_E_B);

/// Of values of `dof` degrees each: 1 = consistent, above = too sure of itself. 0 for none.
double meanNeesPerDof(const std::vector<double>& values, int dof);

}  // namespace vir::evaluation
