#include "image_pyramid.h"

#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

namespace vir::vision {

void ImagePyramid::build(const cv::Mat& gray, int window, int levels) {
  gray.copyTo(full_);
  cv::pyrDown(full_, half_);
  // Zero gradients outside: a patch that hangs over the rim gets no pull from there.
  cv::buildOpticalFlowPyramid(half_, halvings_, cv::Size(window, window), levels - 1, true,
                              cv::BORDER_REFLECT_101, cv::BORDER_CONSTANT, false);
}

void ImagePyramid::swap(ImagePyramid& other) {
  cv::swap(full_, other.full_);
  cv::swap(half_, other.half_);
  halvings_.swap(other.halvings_);
}

void followFlow(const ImagePyramid& a, const ImagePyramid& b, const std::vector<cv::Point2f>& from,
                std::vector<cv::Point2f>* to, std::vector<unsigned char>* found, int window,
                int use_levels, int iterations) {
  found->assign(from.size(), 0);
  if (from.empty()) return;
  const cv::TermCriteria stop(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, iterations, 0.03);
  std::vector<float> error;
  cv::calcOpticalFlowPyrLK(a.halvings(), b.halvings(), from, *to, *found, error,
                           cv::Size(window, window), use_levels, stop, cv::OPTFLOW_USE_INITIAL_FLOW,
                           1e-4);
}

}  // namespace vir::vision
