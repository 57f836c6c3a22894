#include "image_writer.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <opencv2/core/mat.hpp>
#include <opencv2/imgcodecs.hpp>

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
  const bool jpeg = format_ == "jpg";
  const std::vector<int> parameters{jpeg ? cv::IMWRITE_JPEG_QUALITY : cv::IMWRITE_PNG_COMPRESSION,
                                    jpeg ? jpeg_quality_ : 1};
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
