#include "vir/check/image_check.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "text.h"
#include "vir/core/order_statistics.h"

namespace vir::check {
namespace {

constexpr double kBlank = 3, kFlat = 10;     // standard deviation of the grey values
constexpr double kDark = 20, kBright = 235;  // mean grey value
constexpr int kFewCorners = 30;

}  // namespace

void ImageCheck::add(const cv::Mat& gray) {
  if (gray.empty() || gray.type() != CV_8UC1) {
    ++unreadable_;
    return;
  }
  if (count_++ == 0) {
    width_ = gray.cols;
    height_ = gray.rows;
  }
  sizes_differ_ = sizes_differ_ || gray.cols != width_ || gray.rows != height_;
  cv::Scalar mean, spread;
  cv::meanStdDev(gray, mean, spread);
  means_.push_back(mean[0]);
  contrasts_.push_back(spread[0]);
  cv::Mat small;
  cv::resize(gray, small, {64, 48}, 0, 0, cv::INTER_AREA);
  if (!last_.empty() && cv::countNonZero(small != last_) == 0) ++frozen_;
  last_ = small;
}

std::vector<Finding> ImageCheck::findings(int expected_width, int expected_height) const {
  std::vector<Finding> out;
  if (unreadable_ > 0) {
    out.push_back(
        {unreadable_ > count_ / 20 ? Severity::unusable : Severity::doubtful, "unreadable", label_,
         "images cannot be loaded",
         std::to_string(unreadable_) + " of those looked at; the first: " + first_unreadable_,
         "check the files; external images must lie beside the rawlog"});
  }
  if (count_ == 0) return out;
  const std::string size = std::to_string(width_) + "x" + std::to_string(height_);
  const bool fits = expected_width == 0 || (width_ == expected_width && height_ == expected_height);
  if (!fits || sizes_differ_) {
    out.push_back({Severity::unusable, "image_size", label_,
                   sizes_differ_ ? "images have several sizes"
                                 : "images have another size than the calibration",
                   size + (fits ? ""
                                : ", calibration " + std::to_string(expected_width) + "x" +
                                      std::to_string(expected_height)),
                   "give the calibration of this size"});
  }
  const double mean = median(means_), contrast = median(contrasts_);
  const std::string evidence = "median brightness " + num(mean) + ", contrast " + num(contrast) +
                               " of 255 (standard deviation)";
  if (contrast < kFlat) {
    out.push_back(
        {contrast < kBlank ? Severity::unusable : Severity::doubtful,
         contrast < kBlank ? "blank" : "low_contrast", label_,
         contrast < kBlank ? "images are as good as blank" : "images have little contrast",
         evidence,
         "for 12 to 16 bit cameras import again from the original images, which stretches "
         "them; else expose longer"});
  } else if (mean < kDark || mean > kBright) {
    out.push_back({Severity::doubtful, mean < kDark ? "dark" : "bright", label_,
                   mean < kDark ? "images are dark" : "images are overexposed", evidence,
                   "change the exposure"});
  }
  if (frozen_ > count_ / 2 && count_ > 10) {
    out.push_back({Severity::doubtful, "frozen", label_, "most images repeat the one before",
                   std::to_string(frozen_) + " of " + std::to_string(count_), ""});
  }
  if (!corners_.empty() && median(corners_) < kFewCorners && contrast >= kFlat) {
    out.push_back({Severity::doubtful, "few_corners", label_, "there is little to follow",
                   "median of " + std::to_string(median(corners_)) + " corners an image",
                   "more texture, more light, or a sharper lens"});
  }
  return out;
}

}  // namespace vir::check
