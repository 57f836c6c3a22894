#include "image_writer.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <opencv2/core/mat.hpp>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "input_error.h"

namespace vir::simulator {
namespace fs = std::filesystem;

ImageWriter::ImageWriter(std::string folder, std::string format, int jpeg_quality)
    : folder_(std::move(folder)), format_(std::move(format)), jpeg_quality_(jpeg_quality) {}

std::string ImageWriter::write(const std::string& label, TimeNs t,
                               const rendering::GrayImage& image) {
  if (!folder_ready_) {
    std::error_code ec;
    fs::create_directories(folder_, ec);
    if (ec) throw InputError("cannot create the image folder " + folder_ + ": " + ec.message());
    folder_ready_ = true;
  }
  const cv::Mat pixels(image.height, image.width, CV_8UC1,
                       const_cast<std::uint8_t*>(image.pixels.data()));
  // PNG without a level: with any given OpenCV tries all filters, 8 ms instead of 3 for the same
  // size.
  std::vector<int> parameters;
  if (format_ == "jpg") parameters = {cv::IMWRITE_JPEG_QUALITY, jpeg_quality_};
  cv::imencode("." + format_, pixels, bytes_, parameters);
  const std::string name = label + "_" + std::to_string(t) + "." + format_;
  std::ofstream out(folder_ + "/" + name, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes_.data()),
            static_cast<std::streamsize>(bytes_.size()));
  out.close();
  if (!out) throw InputError("cannot write " + folder_ + "/" + name + ": " + std::strerror(errno));
  return name;
}

}  // namespace vir::simulator
