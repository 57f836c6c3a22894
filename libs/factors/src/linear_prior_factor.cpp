#include "vir/factors/linear_prior_factor.h"

#include "vir/factors/pose_manifold.h"

namespace vir::factors {

LinearPriorFactor::LinearPriorFactor(const LinearPrior& prior) : prior_(prior) {
  set_num_residuals(static_cast<int>(prior.r0.size()));
  for (const LinearPrior::Block& b : prior.blocks) {
    mutable_parameter_block_sizes()->push_back(b.ambient);
  }
}

void LinearPriorFactor::difference(double const* const* x, Eigen::VectorXd* dx) const {
  dx->resize(prior_.columns());
  for (std::size_t k = 0; k < prior_.blocks.size(); ++k) {
    const LinearPrior::Block& b = prior_.blocks[k];
    if (b.ambient == 7) {
      poseMinus(x[k], b.x0.data(), dx->data() + b.offset);
    } else {
      for (int i = 0; i < b.ambient; ++i) (*dx)[b.offset + i] = x[k][i] - b.x0[i];
    }
  }
}

void LinearPriorFactor::linearize(double const* const* x, Eigen::MatrixXd* H, Eigen::VectorXd* b,
                                  double* squared) const {
  if (JtJ_.size() == 0) {
    JtJ_.setZero(prior_.columns(), prior_.columns());
    JtJ_.selfadjointView<Eigen::Upper>().rankUpdate(prior_.J.transpose());
    JtJ_.triangularView<Eigen::StrictlyLower>() = JtJ_.transpose();
  }
  Eigen::VectorXd dx;
  difference(x, &dx);
  const Eigen::VectorXd r = prior_.r0 + prior_.J * dx;
  *squared = r.squaredNorm();
  *H = JtJ_;
  b->noalias() = prior_.J.transpose() * r;
  for (const LinearPrior::Block& block : prior_.blocks) {
    if (block.ambient != 7) continue;
    const int at = block.offset + 3;
    const Mat3 by_theta = rightJacobianInverseSO3(dx.segment<3>(at));  // see Evaluate()
    H->middleCols<3>(at) *= by_theta;
    H->middleRows<3>(at).applyOnTheLeft(by_theta.transpose());
    b->segment<3>(at).applyOnTheLeft(by_theta.transpose());
  }
}

bool LinearPriorFactor::Evaluate(double const* const* x, double* residuals,
                                 double** jacobians) const {
  Eigen::VectorXd dx;
  difference(x, &dx);
  const int n = num_residuals();
  Eigen::Map<Eigen::VectorXd>(residuals, n).noalias() = prior_.r0 + prior_.J * dx;
  if (!jacobians) return true;
  for (std::size_t k = 0; k < prior_.blocks.size(); ++k) {
    if (!jacobians[k]) continue;
    const LinearPrior::Block& b = prior_.blocks[k];
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    Eigen::Map<RowMajor> J(jacobians[k], n, b.ambient);
    J.leftCols(b.local()) = prior_.J.middleCols(b.offset, b.local());
    if (b.ambient == 7) {
      // The rotation's difference is Log(q0^-1 q): its derivative is the inverse right Jacobian.
      const Vec3 theta = dx.segment<3>(b.offset + 3);
      J.middleCols<3>(3) = prior_.J.middleCols<3>(b.offset + 3) * rightJacobianInverseSO3(theta);
      J.col(6).setZero();
    }
  }
  return true;
}

}  // namespace vir::factors
