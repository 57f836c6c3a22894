#pragma once
/// Images of ROS, raw or compressed, as 8 bits.
#include <array>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "vir/bags/message_view.h"

namespace vir::bag {

/// What is black and what is white in images of more than 8 bits, the same for the whole recording.
struct Levels {
  double black = 0, white = 0;
  bool known() const { return white > black; }
};

struct Picture {
  cv::Mat pixels;       ///< 8 bit, gray or BGR; may point into the message
  bags::ByteView file;  ///< PNG or JPEG that holds exactly these pixels; empty: there is none
  const char* extension = "";  ///< of `file`
  bool stretched = false;      ///< from more than 8 bits
};

/// As it comes, 8 or 16 bit or float.
struct RawPicture {
  cv::Mat pixels;
  int demosaic = -1;  ///< code of cvtColor once it is 8 bit; -1: none
  bags::ByteView file;
  const char* extension = "";
};

/// Of sensor_msgs/Image or sensor_msgs/CompressedImage. Throws bags::BagError saying why not.
RawPicture decodePicture(const bags::MessageView& message);
/// To 8 bit.
Picture finishPicture(const RawPicture& raw, const Levels& levels);
/// Why it is no image of a camera (depth, or what cannot be read), by its encoding or format alone;
/// empty: it is one.
std::string whyNoPicture(const bags::MessageView& message);

/// Finds the levels from a few images.
class LevelFinder {
 public:
  void add(const cv::Mat& pixels);
  /// Percentiles with some room on either side; not known without images of more than 8 bits.
  Levels levels() const;
  long images() const { return images_; }

 private:
  void addReal(const cv::Mat& pixels);
  Levels realLevels() const;

  std::vector<float> reals_;
  std::vector<long> histogram_;
  long count_ = 0, images_ = 0;
};

}  // namespace vir::bag
