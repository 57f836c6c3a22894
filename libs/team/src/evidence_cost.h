#pragma once
/// -2 log likelihood of a transform, given mutual ranges and common anchors.
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "places_cost.h"
#include "vir/team/find_transform.h"

namespace vir::team {

using Vec4 = Eigen::Vector4d;  // yaw, x, y, z
using Mat4 = Eigen::Matrix4d;
using Mat3x4 = Eigen::Matrix<double, 3, 4>;

Vec4 toVector(const WorldTransform& T);
WorldTransform fromVector(const Vec4& x);

/// d (Rz(yaw) p + t) / d (yaw, t).
Mat3x4 pointJacobian(const Vec3& rotated_p);

/// One range's part in a linearised cost.
struct Innovation {
  double whitened = 0;  ///< measured - predicted given the ranges before, in its own sigmas
  double residual_m = 0;
};

/// The errors of a range are white noise, a slow error of its own and the errors of both positions
/// (Ornstein-Uhlenbeck processes), and what the two worlds have drifted against each other from
/// then to the newest range (a random walk of yaw and offset). A Kalman filter over these, from the
/// newest range back to the oldest, whitens residuals and Jacobians alike in one pass.
class EvidenceCost {
 public:
  /// Keeps references to the first three. Of the standard deviations that are said of positions
  /// `position_share` is taken as true.
  EvidenceCost(const std::vector<MutualRange>& ranges, const std::vector<SharedAnchor>& anchors,
               const TransformOptions& options, double position_share = 1,
               const std::optional<SharedPlaces>& places = {});

  double operator()(const Vec4& x) const;
  /// Gauss-Newton: information `H`, gradient `g` of half the cost.
  double linearise(const Vec4& x, Mat4* H, Vec4* g) const;
  std::vector<Innovation> innovations(const Vec4& x) const;
  /// Squared Mahalanobis distance of an anchor's two positions.
  double anchorChi2(const SharedAnchor& anchor, const Vec4& x) const;
  int anchorsUsed(const Vec4& x) const;
  const PlacesCost& places() const { return places_; }

  std::size_t size() const { return ranges_.size(); }
  const std::vector<MutualRange>& ranges() const { return ranges_; }
  const std::vector<SharedAnchor>& anchors() const { return anchors_; }
  const TransformOptions& options() const { return options_; }

 private:
  /// Columns: the residual, and where `kColumns` is 5 its Jacobian.
  template <int kStates, int kColumns>
  double pass(const Vec4& x, Mat4* H, Vec4* g, std::vector<Innovation>* innovations) const;
  /// What a whitened residual costs, its weight, and the factor its logarithm of a tail is of.
  struct Weighed {
    double cost, weight, tail;
  };
  Weighed weigh(double whitened) const;
  /// Where a range's other end lies, in A's world.
  struct Sight {
    Vec3 direction;  ///< unit length, or zero on the spot
    Vec3 rotated_p_B;
  };
  /// How range `k` answers to the errors that are filtered.
  template <int kStates>
  void sensitivity(std::size_t k, const Mat3& R, const Sight& sight,
                   Eigen::Matrix<double, kStates, 1>* h) const;
  double addAnchors(const Vec4& x, const Mat3& R, Mat4* H, Vec4* g) const;

  const std::vector<MutualRange>& ranges_;
  const std::vector<SharedAnchor>& anchors_;
  const TransformOptions& options_;
  const double position_share_;
  PlacesCost places_;
  struct Step {
    double phi_position, phi_range, dt_s;  ///< to the range after it
    bool exact;                            ///< positions without covariance
  };
  std::vector<Step> steps_;
  bool drift_;
};

struct Descent {
  int iterations = 40;
  double tolerance = 1e-10;    ///< ends when the cost changes by less than this share
  const Vec4* held = nullptr;  ///< the component along this (unit length) stays
};

/// Levenberg-Marquardt from `x`; returns the cost.
double descend(const EvidenceCost& cost, Vec4* x, const Descent& how = {});

}  // namespace vir::team
