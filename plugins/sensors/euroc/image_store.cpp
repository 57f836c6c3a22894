#include "image_store.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "image_head.h"
#include "input_error.h"
#include "vir/core/text.h"

namespace vir::euroc {
namespace fs = std::filesystem;
namespace {

/// Larger files are no camera images; reading them would only fill the memory.
constexpr std::uintmax_t kMaxBytes = 512u << 20;

std::string lowerExtension(const fs::path& p) { return lowerCase(p.extension().string()); }

bool startsWith(const std::vector<unsigned char>& b, std::initializer_list<unsigned char> magic) {
  return b.size() >= magic.size() && std::equal(magic.begin(), magic.end(), b.begin());
}

/// Decoders fill the rest of a cut JPEG with grey and call it a success, so look for its end mark.
/// Within the compressed data FF D9 cannot occur.
bool cutJpeg(const std::vector<unsigned char>& b) {
  if (!startsWith(b, {0xFF, 0xD8})) return false;
  const std::size_t tail = std::min<std::size_t>(b.size(), 4096);
  const unsigned char mark[] = {0xFF, 0xD9};
  return std::search(b.end() - static_cast<std::ptrdiff_t>(tail), b.end(), mark, mark + 2) ==
         b.end();
}

bool cutPng(const std::vector<unsigned char>& b) {
  if (!startsWith(b, {0x89, 'P', 'N', 'G'})) return false;
  const std::size_t tail = std::min<std::size_t>(b.size(), 4096);
  const unsigned char mark[] = {'I', 'E', 'N', 'D'};
  return std::search(b.end() - static_cast<std::ptrdiff_t>(tail), b.end(), mark, mark + 4) ==
         b.end();
}

}  // namespace

bool ImageStore::decode(const std::string& file, const std::string& where) {
  std::error_code ec;
  if (!fs::is_regular_file(file, ec)) {
    log_->add("image_missing", where, "the image " + file + " does not exist");
    return false;
  }
  const auto size = fs::file_size(file, ec);
  std::ifstream in(file, std::ios::binary);
  if (ec || !in || size > kMaxBytes) {
    log_->add("image_undecodable", where, file + " cannot be read");
    return false;
  }
  bytes_.resize(static_cast<std::size_t>(size));
  in.read(reinterpret_cast<char*>(bytes_.data()), static_cast<std::streamsize>(size));
  const bool complete = static_cast<std::uintmax_t>(in.gcount()) == size;
  if (size == 0 || !complete || cutJpeg(bytes_) || cutPng(bytes_)) {
    log_->add("image_undecodable", where, file + (size == 0 ? " is empty" : " is cut short"));
    return false;
  }
  if (!pixelsFit(bytes_.data(), bytes_.size())) {
    log_->add("image_undecodable", where, file + " claims more pixels than it can hold");
    return false;
  }
  try {
    image_ = cv::imdecode(bytes_, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception& e) {
    image_.release();
  }
  if (image_.empty()) {
    log_->add("image_undecodable", where, file + " is not an image that can be decoded");
    return false;
  }
  return rightSize(file, where);
}

bool ImageStore::rightSize(const std::string& what, const std::string& where) {
  if (image_.cols == width_ && image_.rows == height_) return true;
  log_->add("image_wrong_size", where,
            what + " has " + std::to_string(image_.cols) + "x" + std::to_string(image_.rows) +
                " pixels, the calibration " + std::to_string(width_) + "x" +
                std::to_string(height_));
  return false;
}

bool ImageStore::store(TimeNs t, const std::string& file, const std::string& where,
                       StoredImage* out) {
  converted_ = false;
  return decode(file, where) && keep(t, file, where, out);
}

bool ImageStore::store(TimeNs t, const cv::Mat& pixels, const std::string& where,
                       StoredImage* out) {
  image_ = pixels;
  converted_ = true;
  return rightSize("it", where) && keep(t, "", where, out);
}

bool ImageStore::keep(TimeNs t, const std::string& file, const std::string& where,
                      StoredImage* out) {
  const int depth = image_.depth();
  if (depth == CV_16U || (depth == CV_8U && eight_bit_)) {
    const double scale = 255.0 / (white_ - black_);
    image_.convertTo(image_, CV_8U, scale, -black_ * scale);
    log_->count(depth == CV_16U ? "images_converted_16_to_8_bit" : "images_stretched");
    converted_ = true;
  } else if (image_.depth() != CV_8U) {
    log_->add("image_undecodable", where, file + " has pixels that are neither 8 nor 16 bit");
    return false;
  }
  if (image_.channels() == 2 || image_.channels() == 4) {  // with transparency
    if (image_.channels() == 4) cv::cvtColor(image_, image_, cv::COLOR_BGRA2BGR);
    if (image_.channels() == 2) cv::extractChannel(image_, image_, 0);
    converted_ = true;
  }
  if (target_width_ > 0 && (target_width_ != image_.cols || target_height_ != image_.rows)) {
    const bool smaller = target_width_ < image_.cols;
    cv::resize(image_, image_, {target_width_, target_height_}, 0, 0,
               smaller ? cv::INTER_AREA : cv::INTER_LINEAR);
    converted_ = true;
  }
  out->external_name.clear();
  out->pixels.release();
  if (mode_ == ImageMode::embed) {
    out->pixels = image_.clone();
    return true;
  }
  if (!folder_ready_) {
    std::error_code ec;
    fs::create_directories(folder_, ec);
    if (ec) throw InputError("cannot create the image folder " + folder_ + ": " + ec.message());
    folder_ready_ = true;
  }
  const std::string ext = converted_ ? ".png" : lowerExtension(file);
  out->external_name = label_ + "_" + std::to_string(t) + ext;
  place(file, folder_ + "/" + out->external_name);
  return true;
}

void ImageStore::place(const std::string& file, const std::string& target) {
  std::error_code ec;
  fs::remove(target, ec);
  if (converted_) {
    std::vector<unsigned char> png;
    // With any level given OpenCV tries all filters of PNG: half as fast again for 8 % of size.
    cv::imencode(".png", image_, png);
    write(target, png.data(), png.size());
    return;
  }
  if (mode_ == ImageMode::link && links_work_) {
    fs::create_symlink(fs::canonical(file), target, ec);
    if (!ec) return;
    links_work_ = false;
    log_->note(folder_ + ": links cannot be made here (" + ec.message() + "); images are copied");
  }
  write(target, bytes_.data(), bytes_.size());
}

void ImageStore::write(const std::string& target, const void* data, std::size_t size) {
  std::ofstream out(target, std::ios::binary);
  out.write(static_cast<const char*>(data), static_cast<std::streamsize>(size));
  out.close();
  if (!out) throw InputError("cannot write " + target + ": " + std::strerror(errno));
}

}  // namespace vir::euroc
