#pragma once
/// What places that both robots' images show say of a transform.
#include "vir/team/find_transform.h"

namespace vir::team {

/// Squared Mahalanobis distance of yaw and of where B's places come to lie in A's world. Like a
/// wrong anchor, places that only look alike cost `limit` and pull no more.
class PlacesCost {
 public:
  /// Says nothing.
  PlacesCost() = default;
  /// `since_s`: for so long the worlds have drifted against each other since the places were seen.
  PlacesCost(const SharedPlaces& shared, const TransformOptions& options, double since_s);

  bool given() const { return given_; }
  /// (yaw, x, y, z).
  double chi2(const Eigen::Vector4d& x) const;
  bool used(const Eigen::Vector4d& x) const { return given_ && chi2(x) < limit_; }
  /// What it adds to the cost; information and half the gradient are added where they are asked
  /// for.
  double add(const Eigen::Vector4d& x, Eigen::Matrix4d* H, Eigen::Vector4d* g) const;

 private:
  Eigen::Vector4d error(const Eigen::Vector4d& x) const;

  WorldTransform T_A_B_;
  Vec3 centre_A_ = Vec3::Zero(), centre_B_ = Vec3::Zero();
  Eigen::Matrix4d information_ = Eigen::Matrix4d::Zero();  ///< of (yaw, where the centre is in A)
  double limit_ = 0;
  bool given_ = false;
};

}  // namespace vir::team
