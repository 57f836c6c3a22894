#include "vir/rawlog/gray_image.h"

#include <opencv2/imgproc.hpp>

#include "vir/rawlog/mrpt_time.h"

namespace vir::rawlog {

cv::Mat grayOf(const mrpt::obs::CObservationImage& image) {
  const cv::Mat m = image.image.asCvMat<cv::Mat>(mrpt::img::SHALLOW_COPY);
  if (m.channels() == 1) return m;
  cv::Mat gray;
  cv::cvtColor(m, gray, m.channels() == 4 ? cv::COLOR_BGRA2GRAY : cv::COLOR_BGR2GRAY);
  return gray;
}

Image GrayImage::view() const { return {t, pixels.cols, pixels.rows, pixels.data, pixels.step[0]}; }

std::optional<GrayImage> grayImageOf(const mrpt::obs::CObservation& observation) {
  const auto* image = dynamic_cast<const mrpt::obs::CObservationImage*>(&observation);
  if (image == nullptr) return {};
  return GrayImage{fromMrptTime(image->timestamp), grayOf(*image)};
}

}  // namespace vir::rawlog
