#include "image_decoding.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "image_head.h"
#include "raw_image.h"
#include "vir/core/text.h"

namespace vir::bag {
namespace {

using bags::BagError;
using bags::ByteView;
using bags::MessageView;

constexpr int kNo = -1;

bool startsWith(ByteView b, std::string_view magic) {
  return b.text().substr(0, magic.size()) == magic;
}

/// Decoders fill the rest of a cut image with grey and call it a success: look for its end mark.
bool endsSoon(ByteView b, std::string_view mark) {
  const std::string_view text = b.text();
  const std::size_t tail = std::min<std::size_t>(text.size(), 4096);
  return text.substr(text.size() - tail).find(mark) != std::string_view::npos;
}

RawPicture decodeCompressed(const MessageView& m) {
  const ByteView data = m.bytes("data");
  RawPicture out;
  const bool jpeg = startsWith(data, "\xFF\xD8"), png = startsWith(data, "\x89PNG");
  if ((jpeg && !endsSoon(data, "\xFF\xD9")) || (png && !endsSoon(data, "IEND"))) {
    throw BagError("a compressed image is cut short");
  }
  if (!pixelsFit(data.data, data.size)) {
    throw BagError("a compressed image claims more pixels than it can hold");
  }
  if (data.size > 0) {
    try {
      const cv::Mat bytes(1, static_cast<int>(data.size), CV_8UC1,
                          const_cast<std::uint8_t*>(data.data));
      out.pixels = cv::imdecode(bytes, cv::IMREAD_UNCHANGED);
    } catch (const cv::Exception&) {
      out.pixels.release();
    }
  }
  if (out.pixels.empty()) {
    throw BagError("a compressed image (" + std::string(m.text("format").substr(0, 40)) +
                   ") cannot be decoded");
  }
  const int channels = out.pixels.channels();
  if (out.pixels.depth() == CV_8U && (channels == 1 || channels == 3) && (jpeg || png)) {
    out.file = data;
    out.extension = jpeg ? ".jpg" : ".png";
  }
  if (channels == 4) cv::cvtColor(out.pixels, out.pixels, cv::COLOR_BGRA2BGR);
  if (channels == 2) cv::extractChannel(out.pixels, out.pixels, 0);
  return out;
}

}  // namespace

RawPicture decodePicture(const MessageView& message) {
  if (!message.has("encoding")) return decodeCompressed(message);
  const RawPixels raw = decodeRawImage(message);
  RawPicture out;
  out.pixels = raw.pixels;
  out.demosaic = raw.demosaic;
  return out;
}

Picture finishPicture(const RawPicture& raw, const Levels& levels) {
  Picture out;
  out.pixels = raw.pixels;
  out.file = raw.file;
  out.extension = raw.extension;
  const int depth = raw.pixels.depth();
  if (depth == CV_16U || depth == CV_32F) {
    const double black = levels.known() ? levels.black : 0;
    const double white = levels.known() ? levels.white : depth == CV_16U ? 65535 : 1;
    const double scale = 255 / (white - black);
    cv::Mat from = raw.pixels;
    if (depth == CV_32F) {  // what is no number is black, infinity white
      from = raw.pixels.clone();
      cv::patchNaNs(from, black);
      cv::min(from, white, from);
      cv::max(from, black, from);
    }
    cv::Mat stretched;
    from.convertTo(stretched, CV_8U, scale, -black * scale);
    out.pixels = stretched;
    out.stretched = true;
  } else if (depth != CV_8U) {
    throw BagError("an image has pixels that are neither 8 nor 16 bit nor float");
  }
  if (raw.demosaic != kNo) {
    cv::Mat colours;
    cv::cvtColor(out.pixels, colours, raw.demosaic);
    out.pixels = colours;
  }
  return out;
}

std::string whyNoPicture(const MessageView& message) {
  if (message.has("encoding")) return whyNoEncoding(message.text("encoding"));
  const std::string format = lowerCase(std::string(message.text("format").substr(0, 80)));
  if (format.find("compresseddepth") != format.npos) return "depth, no picture of a camera";
  for (const char* video : {"h264", "h265", "hevc", "av1", "vp8", "vp9", "theora"}) {
    if (format.find(video) != format.npos) {
      return "its images are frames of a video (" + format +
             "), which cannot be read: record "
             "them raw, as JPEG or as PNG, or make a video file of them";
    }
  }
  return {};
}

void LevelFinder::add(const cv::Mat& pixels) {
  if (pixels.depth() == CV_32F) addReal(pixels);
  if (pixels.depth() != CV_16U) return;
  ++images_;
  histogram_.resize(65536);
  for (int r = 0; r < pixels.rows; r += 4) {
    const auto* row = pixels.ptr<std::uint16_t>(r);
    for (int c = 0; c < pixels.cols * pixels.channels(); c += 3) {
      ++histogram_[row[c]];
      ++count_;
    }
  }
}

void LevelFinder::addReal(const cv::Mat& pixels) {
  constexpr std::size_t kMost = 4'000'000;
  ++images_;
  for (int r = 0; r < pixels.rows; r += 8) {
    const auto* row = pixels.ptr<float>(r);
    for (int c = 0; c < pixels.cols; c += 5) {
      if (std::isfinite(row[c]) && reals_.size() < kMost) reals_.push_back(row[c]);
    }
  }
}

Levels LevelFinder::realLevels() const {
  std::vector<float> sorted = reals_;
  std::sort(sorted.begin(), sorted.end());
  const std::size_t margin = sorted.size() / 500;
  const double low = sorted[margin], high = sorted[sorted.size() - 1 - margin];
  const double least = 1e-6 * std::max({1.0, std::abs(low), std::abs(high)});
  const double room = std::max(0.1 * (high - low), least);
  return {low - room, high + room};
}

Levels LevelFinder::levels() const {
  if (!reals_.empty()) return realLevels();
  if (count_ == 0) return {};
  const long margin = count_ / 500;
  long below = 0;
  double low = -1, high = 65535;
  for (std::size_t v = 0; v < histogram_.size(); ++v) {
    below += histogram_[v];
    if (low < 0 && below > margin) low = static_cast<double>(v);
    if (below >= count_ - margin) {
      high = static_cast<double>(v);
      break;
    }
  }
  // What comes later may be darker or brighter.
  const double room = 0.1 * std::max(high - low, 16.0);
  return {std::max(0.0, low - room), std::min(65535.0, high + room)};
}

}  // namespace vir::bag
