#pragma once
/// Internal: elimination of the long window's nodes, oldest first. Each node is tied to at most
/// `band` later ones and to the anchors, so that the cost is linear in the number of nodes.
#include <Eigen/Core>
#include <vector>

namespace vir::window {

constexpr int kNodeSize = 5;
constexpr int kAnchorSize = 4;

using Vec5 = Eigen::Matrix<double, 5, 1>;
using Mat5 = Eigen::Matrix<double, 5, 5>;

/// What stays known of a node once it has been eliminated: it follows the nodes after it and the
/// anchors linearly. Its own block is L D L^T.
struct EliminatedNode {
  Mat5 L = Mat5::Identity();                   ///< ones on the diagonal
  Vec5 inverse_d = Vec5::Zero();               ///< of a direction that nothing is known of: zero
  Eigen::Matrix<double, Eigen::Dynamic, 5> y;  ///< coupling to (next `band` nodes, anchors) L^-T
  Vec5 z = Vec5::Zero();                       ///< L^-1 gradient

  /// How it moves when (next `band` nodes, anchors) move by `next`.
  Vec5 follow(const Eigen::VectorXd& next) const;
};

/// Normal equations of (node k, the next `band` nodes, anchors), moving along the chain.
class Frontal {
 public:
  Frontal(int band, int anchors);
  int band() const { return band_; }
  int nodeOffset(int ahead) const { return kNodeSize * ahead; }
  int anchorOffset(int index) const { return kNodeSize * (band_ + 1) + kAnchorSize * index; }
  /// The upper half, and both halves of the blocks on the diagonal. The rest follows from it:
  /// mirror().
  Eigen::MatrixXd H;
  Eigen::VectorXd b;

  /// Adds a scalar or vector residual with Jacobians for two blocks of columns.
  template <int Rows, int A, int B>
  void add(const Eigen::Matrix<double, Rows, 1>& r,
           const Eigen::Matrix<double, Rows, A, (A > 1 ? Eigen::RowMajor : Eigen::ColMajor)>& Ja,
           int at_a,
           const Eigen::Matrix<double, Rows, B, (B > 1 ? Eigen::RowMajor : Eigen::ColMajor)>& Jb,
           int at_b) {
    H.template block<A, A>(at_a, at_a).noalias() += Ja.transpose() * Ja;
    H.template block<B, B>(at_b, at_b).noalias() += Jb.transpose() * Jb;
    const Eigen::Matrix<double, A, B> ab = Ja.transpose() * Jb;
    if (at_a < at_b) {
      H.template block<A, B>(at_a, at_b) += ab;
    } else {
      H.template block<B, A>(at_b, at_a) += ab.transpose();
    }
    b.template segment<A>(at_a).noalias() += Ja.transpose() * r;
    b.template segment<B>(at_b).noalias() += Jb.transpose() * r;
  }

  /// Takes the first node out by a Schur complement and moves on by one node.
  void eliminateFirst(EliminatedNode* out);
  /// Both halves of H are right after this.
  void mirror() { H.triangularView<Eigen::StrictlyLower>() = H.transpose(); }

 private:
  void makeRoom();
  int band_;
  Eigen::VectorXd column_;
};

}  // namespace vir::window
