#pragma once
/// Exposure and contrast of images.
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "vir/check/finding.h"

namespace vir::check {

class ImageCheck {
 public:
  explicit ImageCheck(std::string label) : label_(std::move(label)) {}
  /// One channel of 8 bits.
  void add(const cv::Mat& gray);
  /// One that could not be loaded or decoded, and why.
  void addUnreadable(const std::string& why) {
    if (unreadable_++ == 0) first_unreadable_ = why;
  }
  /// Corners that were found in an image.
  void addCorners(int corners) { corners_.push_back(corners); }
  /// `expected_*`: size in the calibration [px], 0: not known.
  std::vector<Finding> findings(int expected_width, int expected_height) const;

 private:
  std::string label_, first_unreadable_;
  std::vector<double> means_, contrasts_;
  std::vector<int> corners_;
  cv::Mat last_;
  long frozen_ = 0, unreadable_ = 0, count_ = 0;
  int width_ = 0, height_ = 0;
  bool sizes_differ_ = false;
};

}  // namespace vir::check
