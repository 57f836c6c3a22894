#pragma once
/// An image with its halvings and their derivatives, built once.
#include <opencv2/core.hpp>
#include <vector>

namespace vir::vision {

class ImagePyramid {
 public:
  /// Copies `gray` (CV_8UC1) and builds `levels` >= 1 halvings with Scharr derivatives and a border
  /// of `window`. Buffers are reused from one call to the next.
  void build(const cv::Mat& gray, int window, int levels);
  bool empty() const { return full_.empty(); }
  void clear() { full_ = cv::Mat(); }
  void swap(ImagePyramid& other);
  const cv::Mat& full() const { return full_; }
  /// Image and derivative of each halving in turn, as cv::calcOpticalFlowPyrLK takes them.
  const std::vector<cv::Mat>& halvings() const { return halvings_; }
  /// Half resolution, CV_16SC2: 32 times the gradient in grey levels per (half-size) pixel.
  const cv::Mat& gradient() const { return halvings_[1]; }

 private:
  cv::Mat full_, half_;
  std::vector<cv::Mat> halvings_;
};

/// Follows `from` in `a` to `b`, all in pixels of the half resolution. `to` holds the starts and is
/// overwritten. `found[i]` = 0 where it failed. `use_levels`: halvings above half resolution.
void followFlow(const ImagePyramid& a, const ImagePyramid& b, const std::vector<cv::Point2f>& from,
                std::vector<cv::Point2f>* to, std::vector<unsigned char>* found, int window,
                int use_levels, int iterations);

}  // namespace vir::vision
