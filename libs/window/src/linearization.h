#pragma once
/// Internal: terms as normal equations at the current values of their blocks, the landmarks' part
/// kept apart so that they can be eliminated.
#include <Eigen/Core>
#include <vector>

#include "term_layout.h"
#include "vir/factors/camera_parameters.h"
#include "vir/factors/reprojection_factor.h"
#include "vir/geometry/pose.h"

namespace vir::window {

/// What the terms say in all.
struct TermSums {
  double cost = 0;  ///< half the sum of squares, robust losses applied
  /// Whitened squares, without the loss, of residuals with a loss.
  double sight_squares = 0;
  /// Likewise of the readings between two frames: position, rotation, velocity.
  double link_squares = 0;
  int links = 0;
};

/// Adds what a term's residual says to the sums; factor on residual and Jacobians.
double addToSums(const TermLayout::Entry& e, const double* r, int rows, TermSums* sums);

/// Of the pairs of a layout.
using SightGeometries = std::vector<factors::SightGeometry>;
/// At the current values, or where Jacobians are taken.
void geometriesOf(const TermLayout& layout, bool linearized, SightGeometries* out);
/// Residual of a sight of another camera than the host's.
Vec2 rigResidualOf(const TermLayout::Entry& e, const factors::SightGeometry& between,
                   factors::RigJacobians* J);

/// Residuals only.
TermSums evaluate(const TermLayout& layout);

class Linearization {
 public:
  /// The largest block that a sight touches.
  static constexpr int kWidest = factors::kCameraParameters;
  using Coupling = Eigen::Matrix<double, kWidest, 3>;
  /// A landmark's own block; its coupling to the slots of the layout is apart.
  struct OwnBlock {
    Mat3 H = Mat3::Zero();
    Vec3 b = Vec3::Zero();
  };

  /// Of all terms, at the current values. Throws std::runtime_error where one cannot be evaluated.
  void linearize(const TermLayout& layout);

  const TermSums& sums() const { return sums_; }
  /// Of all blocks but the landmarks; only what lies on and above the diagonal.
  const Eigen::MatrixXd& H() const { return H_; }
  const Eigen::VectorXd& b() const { return b_; }
  const OwnBlock& own(std::size_t landmark) const { return own_[landmark]; }
  const Coupling& coupling(int slot) const { return coupling_[static_cast<std::size_t>(slot)]; }

 private:
  /// What the sights of one host have in common: host, and the calibration (extrinsics, camera).
  struct CommonSum {
    int columns[3] = {-1, -1, -1};
    Eigen::Matrix<double, 20, 20> H;
    Eigen::Matrix<double, 20, 1> b;
  };
  /// Likewise of sights of another camera than the host's: the host's pose, then extrinsics and
  /// camera of the host and of the sight.
  struct RigSum {
    static constexpr int kBlocks = 5, kSize = 34;
    static constexpr int sizes[kBlocks] = {6, 6, 8, 6, 8}, at[kBlocks] = {0, 6, 12, 20, 26};
    int columns[kBlocks] = {-1, -1, -1, -1, -1};
    Eigen::Matrix<double, kSize, kSize> H;
    Eigen::Matrix<double, kSize, 1> b;
  };
  template <typename Factor>
  void addSight(const TermLayout& layout, const TermLayout::Entry& e, OwnBlock* own);
  void addDense(const TermLayout& layout, const TermLayout::Entry& e);
  void addPrior(const TermLayout& layout, const TermLayout::Entry& e);
  void addOfLandmark(const TermLayout& layout, const TermLayout::Entry& e, OwnBlock* own);
  Coupling& coupling(const TermLayout& layout, const TermLayout::Entry& e, int block) {
    return coupling_[static_cast<std::size_t>(layout.slotOf(e, block))];
  }
  void evaluateStacked(const TermLayout::Entry& e);
  void scatter(const TermLayout& layout, const TermLayout::Entry& e,
               const std::vector<int>& columns);
  template <int size>
  void flush(CommonSum* sum);
  void addRigSight(const TermLayout& layout, const TermLayout::Entry& e, OwnBlock* own);
  void flushRig();
  /// On or below the diagonal: where it stands transposed.
  template <typename Block>
  void addBlock(int row, int column, const Block& block);

  Eigen::MatrixXd H_;
  Eigen::VectorXd b_;
  std::vector<OwnBlock> own_;
  std::vector<Coupling, Eigen::aligned_allocator<Coupling>> coupling_;
  TermSums sums_;
  CommonSum with_calibration_, without_;
  RigSum rig_;
  SightGeometries now_, linearized_;
  // Scratch of terms of any kind: blocks as evaluated, stacked, and their products.
  std::vector<double> raw_;
  std::vector<double*> pointers_;
  std::vector<int> stacked_;  ///< first column of each block in J_
  Eigen::VectorXd r_;
  Eigen::MatrixXd J_, product_;
  Eigen::VectorXd gradient_;
};

/// How strongly a landmark's block is damped, by local coordinate.
using LandmarkDamping = std::vector<Vec3>;

/// Takes the landmarks out of H and b, which are those of a linearisation. Rank-safe: a direction
/// in which a landmark is not observed stays out.
void eliminateLandmarks(const TermLayout& layout, const Linearization& lin, Eigen::MatrixXd* H,
                        Eigen::VectorXd* b);
/// Likewise with each landmark's block damped, so that it can be inverted: `inverses` has these.
/// False where it cannot.
bool eliminateDamped(const TermLayout& layout, const Linearization& lin,
                     const LandmarkDamping& damping, Eigen::MatrixXd* H, Eigen::VectorXd* b,
                     std::vector<Mat3>* inverses);

}  // namespace vir::window
