#include "image_decoding.h"

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "image_head.h"

namespace vir::bag {
namespace {

using bags::BagError;
using bags::ByteView;
using bags::MessageView;

constexpr int kLargest = 20'000;  ///< [px]

struct Encoding {
  const char* name;
  int type;      ///< of cv::Mat
  int convert;   ///< while it still has its own channels; -1: as it is
  int demosaic;  ///< once it is 8 bit; -1: none
};
constexpr int kNo = -1;
// OpenCV calls Bayer patterns by their second row: RGGB is its BG.
constexpr Encoding kEncodings[] = {
    {"mono8", CV_8UC1, kNo, kNo},
    {"8UC1", CV_8UC1, kNo, kNo},
    {"mono16", CV_16UC1, kNo, kNo},
    {"16UC1", CV_16UC1, kNo, kNo},
    {"bgr8", CV_8UC3, kNo, kNo},
    {"8UC3", CV_8UC3, kNo, kNo},
    {"rgb8", CV_8UC3, cv::COLOR_RGB2BGR, kNo},
    {"bgra8", CV_8UC4, cv::COLOR_BGRA2BGR, kNo},
    {"8UC4", CV_8UC4, cv::COLOR_BGRA2BGR, kNo},
    {"rgba8", CV_8UC4, cv::COLOR_RGBA2BGR, kNo},
    {"bgr16", CV_16UC3, kNo, kNo},
    {"rgb16", CV_16UC3, cv::COLOR_RGB2BGR, kNo},
    {"bayer_rggb8", CV_8UC1, kNo, cv::COLOR_BayerBG2BGR},
    {"bayer_bggr8", CV_8UC1, kNo, cv::COLOR_BayerRG2BGR},
    {"bayer_gbrg8", CV_8UC1, kNo, cv::COLOR_BayerGR2BGR},
    {"bayer_grbg8", CV_8UC1, kNo, cv::COLOR_BayerGB2BGR},
    {"bayer_rggb16", CV_16UC1, kNo, cv::COLOR_BayerBG2BGR},
    {"bayer_bggr16", CV_16UC1, kNo, cv::COLOR_BayerRG2BGR},
    {"bayer_gbrg16", CV_16UC1, kNo, cv::COLOR_BayerGR2BGR},
    {"bayer_grbg16", CV_16UC1, kNo, cv::COLOR_BayerGB2BGR},
    {"yuv422", CV_8UC2, cv::COLOR_YUV2BGR_UYVY, kNo},
    {"uyvy", CV_8UC2, cv::COLOR_YUV2BGR_UYVY, kNo},
    {"yuv422_yuy2", CV_8UC2, cv::COLOR_YUV2BGR_YUY2, kNo},
    {"yuyv", CV_8UC2, cv::COLOR_YUV2BGR_YUY2, kNo},
};

const Encoding* encodingOf(std::string_view name) {
  for (const Encoding& e : kEncodings) {
    if (name == e.name) return &e;
  }
  return nullptr;
}

std::string knownEncodings() {
  std::string out;
  for (const Encoding& e : kEncodings) out += std::string(out.empty() ? "" : " ") + e.name;
  return out;
}

RawPicture decodeRaw(const MessageView& m) {
  const std::string_view name = m.text("encoding");
  const Encoding* e = encodingOf(name);
  if (e == nullptr) {
    throw BagError("image encoding '" + std::string(name.substr(0, 40)) +
                   "' cannot be read; known are " + knownEncodings());
  }
  const std::int64_t width = m.integer("width"), height = m.integer("height");
  const std::int64_t step = m.integer("step");
  const ByteView data = m.bytes("data");
  const std::int64_t least = width * static_cast<std::int64_t>(CV_ELEM_SIZE(e->type));
  if (width < 1 || height < 1 || width > kLargest || height > kLargest || step < least ||
      (height - 1) * step + least > static_cast<std::int64_t>(data.size)) {
    throw BagError("image of " + std::to_string(width) + "x" + std::to_string(height) +
                   " pixels, " + std::to_string(step) + " bytes a row, has only " +
                   std::to_string(data.size) + " bytes");
  }
  // OpenCV takes no pointer to what is not to change.
  cv::Mat view(static_cast<int>(height), static_cast<int>(width), e->type,
               const_cast<std::uint8_t*>(data.data), static_cast<std::size_t>(step));
  RawPicture out;
  out.demosaic = e->demosaic;
  if (CV_MAT_DEPTH(e->type) == CV_16U) {
    // Bytes of a message lie anywhere; words must not.
    out.pixels = view.clone();
    if (m.integer("is_bigendian") != 0) {
      cv::Mat bytes(out.pixels.rows, out.pixels.cols * out.pixels.channels(), CV_8UC2,
                    out.pixels.data);
      const int swap[] = {0, 1, 1, 0};
      cv::Mat swapped(bytes.size(), CV_8UC2);
      cv::mixChannels(&bytes, 1, &swapped, 1, swap, 2);
      swapped.copyTo(bytes);
    }
    view = out.pixels;
  }
  if (e->convert == kNo) {
    out.pixels = view;
  } else {
    cv::Mat converted;
    cv::cvtColor(view, converted, e->convert);
    out.pixels = converted;
  }
  return out;
}

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
  return message.has("encoding") ? decodeRaw(message) : decodeCompressed(message);
}

Picture finishPicture(const RawPicture& raw, const Levels& levels) {
  Picture out;
  out.pixels = raw.pixels;
  out.file = raw.file;
  out.extension = raw.extension;
  if (raw.pixels.depth() == CV_16U) {
    const double black = levels.known() ? levels.black : 0;
    const double white = levels.known() ? levels.white : 65535;
    const double scale = 255 / (white - black);
    cv::Mat stretched;
    raw.pixels.convertTo(stretched, CV_8U, scale, -black * scale);
    out.pixels = stretched;
    out.stretched = true;
  } else if (raw.pixels.depth() != CV_8U) {
    throw BagError("an image has pixels that are neither 8 nor 16 bit");
  }
  if (raw.demosaic != kNo) {
    cv::Mat colours;
    cv::cvtColor(out.pixels, colours, raw.demosaic);
    out.pixels = colours;
  }
  return out;
}

bool isCameraEncoding(const MessageView& message) {
  if (message.has("encoding")) return encodingOf(message.text("encoding")) != nullptr;
  return message.text("format").find("compressedDepth") == std::string_view::npos;
}

void LevelFinder::add(const cv::Mat& pixels) {
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

Levels LevelFinder::levels() const {
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
