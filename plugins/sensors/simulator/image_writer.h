#pragma once
#include <string>
#include <vector>

#include "vir/core/time.h"
#include "vir/rendering/camera_simulator.h"

namespace vir::simulator {

/// Writes images to a folder as <label>_<time in ns>.jpg or .png.
class ImageWriter {
 public:
  /// `format` is "jpg" or "png". The folder is created with the first image.
  ImageWriter(std::string folder, std::string format, int jpeg_quality);
  /// Returns the file's name in the folder. Throws InputError if it cannot be written.
  std::string write(const std::string& label, TimeNs t, const rendering::GrayImage& image);

 private:
  std::string folder_, format_;
  int jpeg_quality_;
  bool folder_ready_ = false;
  std::vector<unsigned char> bytes_;
};

}  // namespace vir::simulator
