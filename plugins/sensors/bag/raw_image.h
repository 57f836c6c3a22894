#pragma once
/// sensor_msgs/Image: pixels as they are recorded.
#include <opencv2/core/mat.hpp>
#include <string>
#include <string_view>

#include "vir/bags/message_view.h"

namespace vir::bag {

struct RawPixels {
  cv::Mat pixels;     ///< 8 or 16 bit or float; may point into the message
  int demosaic = -1;  ///< code of cvtColor once it is 8 bit; -1: none
};

/// Throws bags::BagError saying why not. Of YUV in planes (nv12, i420, ...) the luminance.
RawPixels decodeRawImage(const bags::MessageView& message);
/// Empty: an encoding that is known.
std::string whyNoEncoding(std::string_view name);

}  // namespace vir::bag
