#pragma once
/// New corners where the image has room for them.
#include <opencv2/core.hpp>
#include <vector>

namespace vir::vision {

struct DetectorOptions {
  int cell_px = 60;
  double min_distance_px = 25;
  double min_score = 20;  ///< smaller eigenvalue of the mean gradient tensor [(grey levels/px)^2]
  int border_px = 12;     ///< no corner nearer to the rim
};

/// Shi-Tomasi corners on a grid. Only cells that hold too few features are looked at, and one where
/// nothing was found rests for some images.
class CornerDetector {
 public:
  explicit CornerDetector(const DetectorOptions& options) : options_(options) {}

  /// Up to `wanted` corners at sub-pixel positions, each at least min_distance_px from `existing`
  /// and from each other; emptier cells and better scores first. `gradient` is CV_16SC2 with 32
  /// times the gradient in grey levels per pixel.
  std::vector<cv::Point2f> detect(const cv::Mat& gradient, const std::vector<cv::Point2f>& existing,
                                  int wanted);
  /// Looks at all cells again.
  void reset() { resting_.clear(); }

 private:
  struct Candidate {
    cv::Point2f at;
    float score;
    int occupancy;  ///< features its cell held before
  };
  void scoreRegion(const cv::Mat& gradient, const cv::Rect& region);
  bool collectCell(const cv::Mat& gradient, const cv::Rect& cell, int occupancy);
  bool blocked(const cv::Point2f& p, const std::vector<cv::Point2f>& others) const;

  DetectorOptions options_;
  std::vector<int> resting_;  ///< images each cell is still left alone
  std::vector<int> occupancy_;
  std::vector<Candidate> candidates_;
  std::vector<cv::Point2f> near_;  ///< existing features that can block corners of this cell
  cv::Mat score_, rows_;           ///< scratch
};

}  // namespace vir::vision
