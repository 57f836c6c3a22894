#pragma once
/// Checks the images of a recording and brings them to where the rawlog finds them.
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "problem_log.h"
#include "vir/core/time.h"

namespace vir::euroc {

enum class ImageMode { link, copy, embed };

struct StoredImage {
  std::string external_name;  ///< file name in the image folder; empty: `pixels` holds the image
  cv::Mat pixels;             ///< decoded, 8 bit, one or three channels
};

class ImageStore {
 public:
  /// `folder` receives links or copies; it is created with the first image. Size in pixels as in
  /// the calibration.
  ImageStore(ImageMode mode, std::string folder, std::string label, int width, int height,
             ProblemLog* log)
      : mode_(mode),
        folder_(std::move(folder)),
        label_(std::move(label)),
        width_(width),
        height_(height),
        log_(log) {}

  /// Pixels of 16 bits, or of 8 (`eight_bit`; else they stay as they are), that become 0 and 255.
  void setStretch(double black, double white, bool eight_bit = false) {
    black_ = black;
    white_ = white;
    eight_bit_ = eight_bit;
  }

  /// Images become this large.
  void setTarget(int width, int height) {
    target_width_ = width;
    target_height_ = height;
  }

  /// Decodes `file` and stores it. False, counted in the log with `where`, if it is missing, cannot
  /// be decoded or has another size. Throws InputError if the folder cannot be written.
  bool store(TimeNs t, const std::string& file, const std::string& where, StoredImage* out);
  /// The same of an image that is in memory; outside of the rawlog it becomes a PNG.
  bool store(TimeNs t, const cv::Mat& pixels, const std::string& where, StoredImage* out);

 private:
  bool rightSize(const std::string& what, const std::string& where);
  bool keep(TimeNs t, const std::string& file, const std::string& where, StoredImage* out);
  bool decode(const std::string& file, const std::string& where);
  void place(const std::string& file, const std::string& target);
  void write(const std::string& target, const void* data, std::size_t size);

  ImageMode mode_;
  std::string folder_, label_;
  int width_, height_;
  int target_width_ = 0, target_height_ = 0;
  double black_ = 0, white_ = 65535;
  bool eight_bit_ = false;
  ProblemLog* log_;
  bool folder_ready_ = false, links_work_ = true;
  std::vector<unsigned char> bytes_;
  cv::Mat image_;
  bool converted_ = false;  ///< `image_` differs from what the file holds
};

}  // namespace vir::euroc
