#pragma once
#include <mrpt/obs/CObservationImage.h>

#include <opencv2/core.hpp>

namespace vir::rawlog {

/// The image as one 8-bit channel; shares the pixels where it is one already. Throws what MRPT
/// throws for a file that cannot be read.
cv::Mat grayOf(const mrpt::obs::CObservationImage& image);

}  // namespace vir::rawlog
