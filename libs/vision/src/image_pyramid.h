#pragma once
/// An image with its pyramid and derivatives, built once.
#include <opencv2/core.hpp>
#include <vector>

namespace vir {

class ImagePyramid {
 public:
  /// Builds `levels` halvings of `gray` (CV_8UC1) and their Scharr derivatives, with a border of
  /// `window` around each. Buffers are reused from one call to the next.
  void build(const cv::Mat& gray, int window, int levels);
  bool empty() const { return levels_.empty(); }
  void clear() { levels_.clear(); }
  void swap(ImagePyramid& other) { levels_.swap(other.levels_); }
  /// Image and derivative of each level in turn, as cv::calcOpticalFlowPyrLK takes them.
  const std::vector<cv::Mat>& levels() const { return levels_; }
  const cv::Mat& image() const { return levels_[0]; }
  /// CV_16SC2: 32 times the gradient in grey levels per pixel.
  const cv::Mat& gradient() const { return levels_[1]; }

 private:
  std::vector<cv::Mat> levels_;
};

/// Follows `from` in `a` to `b`. `to` holds the starts and is overwritten. `found[i]` = 0 where it
/// failed. `use_levels` <= the pyramid's levels.
void followFlow(const ImagePyramid& a, const ImagePyramid& b, const std::vector<cv::Point2f>& from,
                std::vector<cv::Point2f>* to, std::vector<unsigned char>* found, int window,
                int use_levels, int iterations);

}  // namespace vir
