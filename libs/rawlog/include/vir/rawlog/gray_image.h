#pragma once
#include <mrpt/obs/CObservationImage.h>

#include <opencv2/core.hpp>
#include <optional>

#include "vir/types/image.h"

namespace vir::rawlog {

/// The image as one 8-bit channel; shares the pixels where it is one already. Throws what MRPT
/// throws for a file that cannot be read.
cv::Mat grayOf(const mrpt::obs::CObservationImage& image);

/// An image with its pixels: its own, or those of the observation where they are gray already.
struct GrayImage {
  TimeNs t = 0;  ///< on the camera's clock
  cv::Mat pixels;
  Image view() const;
};
/// Empty for other classes. Throws as grayOf() does.
std::optional<GrayImage> grayImageOf(const mrpt::obs::CObservation& observation);

}  // namespace vir::rawlog
