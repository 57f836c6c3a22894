#include "vir/rawlog/gray_image.h"

#include <opencv2/imgproc.hpp>

namespace vir::rawlog {

cv::Mat grayOf(const mrpt::obs::CObservationImage& image) {
  const cv::Mat m = image.image.asCvMat<cv::Mat>(mrpt::img::SHALLOW_COPY);
  if (m.channels() == 1) return m;
  cv::Mat gray;
  cv::cvtColor(m, gray, m.channels() == 4 ? cv::COLOR_BGRA2GRAY : cv::COLOR_BGR2GRAY);
  return gray;
}

}  // namespace vir::rawlog
