#pragma once
/// A patch remembered from the image a feature was first seen in, and its alignment with later
/// ones.
#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "vir/geometry/so3.h"

namespace vir::vision {

/// Maps patch coordinates (pixels from the patch's centre) to an image: A x + c.
struct PatchWarp {
  Eigen::Matrix2d A = Eigen::Matrix2d::Identity();
  Vec2 c = Vec2::Zero();  ///< [px]
};

struct AlignOptions {
  int max_iterations = 8;
  double max_shift_px = 4.0;    ///< farther from the start is a failure
  double min_similarity = 0.8;  ///< normalised cross-correlation at the end
};

/// Squared patch of grey levels around a pixel. Alignment estimates an affine warp and is blind to
/// gain and offset of the grey levels, so it survives exposure changes; because every image is
/// compared with the same patch, errors do not add up along a track.
class Patch {
 public:
  /// Takes the patch of `half` px to each side from `image` (CV_8UC1) around the whole pixel
  /// nearest to `px`. False, with nothing taken, if it does not fit into the image or has no
  /// texture.
  bool take(const cv::Mat& image, const Vec2& px, int half);
  /// Inverse-compositional Gauss-Newton from `warp`. False if it fails; `warp` is then undefined.
  bool align(const cv::Mat& image, const AlignOptions& options, PatchWarp* warp) const;
  /// Where the feature itself (px of take()) is under `warp`.
  Vec2 feature(const PatchWarp& warp) const { return warp.A * offset_ + warp.c; }
  /// The warp to the image it was taken from.
  PatchWarp origin() const { return {Eigen::Matrix2d::Identity(), centre_}; }
  bool empty() const { return half_ == 0; }
  int half() const { return half_; }

 private:
  bool sample(const cv::Mat& image, const PatchWarp& warp, Eigen::VectorXf* values) const;

  int half_ = 0;
  Vec2 centre_ = Vec2::Zero();
  Vec2 offset_ = Vec2::Zero();  ///< of the feature from the centre, at most half a pixel
  Eigen::VectorXf values_;      ///< grey levels with their mean taken off
  float norm_ = 0.0f;           ///< length of values_
  Eigen::Matrix<float, Eigen::Dynamic, 8> jacobian_;
  Eigen::Matrix<double, 8, 8> inverse_ =
      Eigen::Matrix<double, 8, 8>::Zero();  ///< of the normal matrix
};

}  // namespace vir::vision
