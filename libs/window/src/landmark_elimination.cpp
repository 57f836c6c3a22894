#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>

#include "linearization.h"

namespace vir::window {
namespace {

using Coupling = Linearization::Coupling;

/// Inverse of a landmark's block, in closed form where it is well observed; else a direction whose
/// eigenvalue is next to nothing gets none.
Mat3 scaledPseudoInverse(const Mat3& H) {
  constexpr double kNothing = 1e-9;
  const Vec3 s = H.diagonal().unaryExpr([](double d) { return d > 0 ? 1.0 / std::sqrt(d) : 0.0; });
  const Mat3 A = s.asDiagonal() * H * s.asDiagonal();
  // Its diagonal is one: the determinant is below the product of the two larger eigenvalues (at
  // most 9/4) times the smallest.
  if (A.determinant() > 1e-6) return s.asDiagonal() * A.inverse() * s.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Mat3> eig(A);
  const Vec3 inverse =
      eig.eigenvalues().unaryExpr([](double l) { return l > kNothing ? 1.0 / l : 0.0; });
  const Mat3 V = s.asDiagonal() * eig.eigenvectors();
  return V * inverse.asDiagonal() * V.transpose();
}

template <int rows, int columns>
void subtract(const Coupling& W, const Coupling& other, int i, int j, Eigen::MatrixXd* H) {
  H->block<rows, columns>(i, j) -=
      W.topRows<rows>().lazyProduct(other.topRows<columns>().transpose());
}

void eliminate(const TermLayout& layout, const TermLayout::LandmarkTerms& l,
               const Linearization& lin, const Vec3& gradient, const Mat3& inverse,
               Eigen::MatrixXd* H, Eigen::VectorXd* b) {
  for (int i = l.first_slot; i < l.first_slot + l.slots; ++i) {
    const TermLayout::Slot& a = layout.slot(i);
    const Coupling W = lin.coupling(i) * inverse;
    const Eigen::Matrix<double, Linearization::kWidest, 1> Wb = W * gradient;
    b->segment(a.offset, a.size) -= Wb.head(a.size);
    for (int j = i; j < l.first_slot + l.slots; ++j) {
      const TermLayout::Slot& c = layout.slot(j);
      const Coupling& other = lin.coupling(j);
      if (a.size == 6 && c.size == 6) {
        subtract<6, 6>(W, other, a.offset, c.offset, H);
      } else if (a.size == 6 && c.size == 8) {
        subtract<6, 8>(W, other, a.offset, c.offset, H);
      } else if (a.size == 8 && c.size == 8) {
        subtract<8, 8>(W, other, a.offset, c.offset, H);
      } else {
        H->block(a.offset, c.offset, a.size, c.size) -=
            W.topRows(a.size) * other.topRows(c.size).transpose();
      }
    }
  }
}

}  // namespace

void eliminateLandmarks(const TermLayout& layout, const Linearization& lin, Eigen::MatrixXd* H,
                        Eigen::VectorXd* b) {
  for (std::size_t k = 0; k < layout.landmarks().size(); ++k) {
    const Linearization::OwnBlock& own = lin.own(k);
    eliminate(layout, layout.landmarks()[k], lin, own.b, scaledPseudoInverse(own.H), H, b);
  }
}

bool eliminateDamped(const TermLayout& layout, const Linearization& lin,
                     const LandmarkDamping& damping, Eigen::MatrixXd* H, Eigen::VectorXd* b,
                     std::vector<Mat3>* inverses) {
  inverses->resize(layout.landmarks().size());
  for (std::size_t k = 0; k < layout.landmarks().size(); ++k) {
    const Linearization::OwnBlock& own = lin.own(k);
    Mat3 damped = own.H;
    damped.diagonal() += damping[k];
    const Eigen::LLT<Mat3> llt(damped);
    if (llt.info() != Eigen::Success) return false;
    Mat3& inverse = (*inverses)[k];
    inverse = llt.solve(Mat3::Identity());
    eliminate(layout, layout.landmarks()[k], lin, own.b, inverse, H, b);
  }
  return true;
}

}  // namespace vir::window
