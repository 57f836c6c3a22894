#include "raw_image.h"

#include <algorithm>
#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "vir/core/parse_number.h"
#include "vir/core/text.h"

namespace vir::bag {
namespace {

using bags::BagError;
using bags::ByteView;

constexpr int kLargest = 20'000;  ///< [px]
constexpr int kNo = -1;

/// How pixels of 10 and 12 bits share bytes.
enum class Packing {
  none,
  bits,  ///< one behind the other, lowest bit first (Mono12p of GenICam)
  pair   ///< two in three bytes, their low bits in the middle (Mono12Packed of GigE Vision)
};

struct Encoding {
  std::string_view name;
  int type = 0;         ///< of cv::Mat
  int convert = kNo;    ///< while it still has its own channels; -1: as it is
  int demosaic = kNo;   ///< once it is 8 bit; -1: none
  int half_planes = 2;  ///< bytes of all planes by half those of the first, which is taken
  Packing packing = Packing::none;
  int bits = 0;  ///< of packed pixels
};

constexpr Encoding kEncodings[] = {
    {"mono8", CV_8UC1},
    {"8uc1", CV_8UC1},
    {"mono16", CV_16UC1},
    {"16uc1", CV_16UC1},
    {"bgr8", CV_8UC3},
    {"8uc3", CV_8UC3},
    {"rgb8", CV_8UC3, cv::COLOR_RGB2BGR},
    {"bgra8", CV_8UC4, cv::COLOR_BGRA2BGR},
    {"8uc4", CV_8UC4, cv::COLOR_BGRA2BGR},
    {"rgba8", CV_8UC4, cv::COLOR_RGBA2BGR},
    {"bgr16", CV_16UC3},
    {"16uc3", CV_16UC3},
    {"rgb16", CV_16UC3, cv::COLOR_RGB2BGR},
    {"bgra16", CV_16UC4, cv::COLOR_BGRA2BGR},
    {"16uc4", CV_16UC4, cv::COLOR_BGRA2BGR},
    {"rgba16", CV_16UC4, cv::COLOR_RGBA2BGR},
    {"16sc1", CV_16SC1},
    {"32sc1", CV_32SC1},
    {"32fc1", CV_32FC1},
    {"64fc1", CV_64FC1},
    {"yuv422", CV_8UC2, cv::COLOR_YUV2BGR_UYVY},
    {"uyvy", CV_8UC2, cv::COLOR_YUV2BGR_UYVY},
    {"yuv422_yuy2", CV_8UC2, cv::COLOR_YUV2BGR_YUY2},
    {"yuyv", CV_8UC2, cv::COLOR_YUV2BGR_YUY2},
    {"yuy2", CV_8UC2, cv::COLOR_YUV2BGR_YUY2},
    {"nv12", CV_8UC1, kNo, kNo, 3},
    {"nv21", CV_8UC1, kNo, kNo, 3},
    {"i420", CV_8UC1, kNo, kNo, 3},
    {"yv12", CV_8UC1, kNo, kNo, 3},
    {"yuv420", CV_8UC1, kNo, kNo, 3},
    {"yuv420p", CV_8UC1, kNo, kNo, 3},
    {"nv16", CV_8UC1, kNo, kNo, 4},
    {"nv61", CV_8UC1, kNo, kNo, 4},
    {"yuv422p", CV_8UC1, kNo, kNo, 4},
    {"nv24", CV_8UC1, kNo, kNo, 6},
};

struct Pattern {
  std::string_view name, genicam;
  int demosaic;
};
// OpenCV calls Bayer patterns by their second row: RGGB is its BG.
constexpr Pattern kPatterns[] = {{"bayer_rggb", "bayerrg", cv::COLOR_BayerBG2BGR},
                                 {"bayer_bggr", "bayerbg", cv::COLOR_BayerRG2BGR},
                                 {"bayer_gbrg", "bayergb", cv::COLOR_BayerGR2BGR},
                                 {"bayer_grbg", "bayergr", cv::COLOR_BayerGB2BGR}};

/// `mono12`, `bayer_rggb10p`, `BayerRG12Packed`: a base, bits, and how they are packed.
std::optional<Encoding> byParts(const std::string& name) {
  Encoding e;
  std::string_view rest = name;
  const auto takeFront = [&](std::string_view front) {
    if (rest.substr(0, front.size()) != front) return false;
    rest.remove_prefix(front.size());
    return true;
  };
  bool base = takeFront("mono");
  for (const Pattern& p : kPatterns) {
    if (base) break;
    base = takeFront(p.name) || takeFront(p.genicam);
    if (base) e.demosaic = p.demosaic;
  }
  const std::size_t digits = std::min(rest.find_first_not_of("0123456789"), rest.size());
  if (!base || !parseNumber(rest.substr(0, digits), &e.bits) || e.bits < 8 || e.bits > 16 ||
      e.bits % 2 != 0) {
    return std::nullopt;
  }
  rest.remove_prefix(digits);
  e.type = e.bits == 8 ? CV_8UC1 : CV_16UC1;
  if (rest.empty()) return e;
  const bool packs = e.bits == 10 || e.bits == 12;
  e.packing = rest == "p" ? Packing::bits : Packing::pair;
  if (!packs || (rest != "p" && rest != "packed")) return std::nullopt;
  return e;
}

std::optional<Encoding> encodingOf(std::string_view written) {
  const std::string name = lowerCase(std::string(written));
  for (const Encoding& e : kEncodings) {
    if (name == e.name) return e;
  }
  return byParts(name);
}

std::int64_t rowBytes(const Encoding& e, std::int64_t width) {
  switch (e.packing) {
    case Packing::bits:
      return (width * e.bits + 7) / 8;
    case Packing::pair:
      return (width + 1) / 2 * 3;
    case Packing::none:
      break;
  }
  return width * static_cast<std::int64_t>(CV_ELEM_SIZE(e.type));
}

void unpackRow(const Encoding& e, const std::uint8_t* in, int width, std::uint16_t* out) {
  const unsigned mask = (1u << e.bits) - 1;
  for (int x = 0; x < width; ++x) {
    if (e.packing == Packing::bits) {
      const std::size_t bit = static_cast<std::size_t>(x) * static_cast<std::size_t>(e.bits);
      const std::uint8_t* b = in + bit / 8;
      // 10 and 12 bits that begin at an even bit lie in two bytes.
      out[x] = static_cast<std::uint16_t>(((b[0] | (b[1] << 8)) >> (bit % 8)) & mask);
      continue;
    }
    const std::uint8_t* b = in + x / 2 * 3;
    const int low = e.bits - 8, shift = x % 2 == 0 ? 0 : 4;
    const int high = x % 2 == 0 ? b[0] : b[2];
    out[x] = static_cast<std::uint16_t>((high << low) | ((b[1] >> shift) & ((1 << low) - 1)));
  }
}

cv::Mat unpacked(const Encoding& e, const ByteView& data, int width, int height,
                 std::int64_t step) {
  cv::Mat out(height, width, CV_16UC1);
  for (int y = 0; y < height; ++y) {
    unpackRow(e, data.data + y * step, width, out.ptr<std::uint16_t>(y));
  }
  return out;
}

/// Bytes of a message lie anywhere; words must not.
cv::Mat aligned(const cv::Mat& view, bool big_endian) {
  cv::Mat out = view.clone();
  if (!big_endian) return out;
  const std::size_t size = out.elemSize1();
  std::uint8_t* end = out.data + out.total() * out.elemSize();
  for (std::uint8_t* word = out.data; word < end; word += size) std::reverse(word, word + size);
  return out;
}

}  // namespace

std::string whyNoEncoding(std::string_view name) {
  if (encodingOf(name)) return {};
  std::string known;
  for (const Encoding& e : kEncodings) known += std::string(e.name) + " ";
  return "image encoding '" + std::string(name.substr(0, 40)) + "' cannot be read; known are " +
         known + "and mono, bayer_rggb, ... of 8 to 16 bits, of 10 and 12 also packed (p, packed)";
}

RawPixels decodeRawImage(const bags::MessageView& m) {
  const std::string_view name = m.text("encoding");
  const std::optional<Encoding> e = encodingOf(name);
  if (!e) throw BagError(whyNoEncoding(name));
  const std::int64_t width = m.integer("width"), height = m.integer("height");
  const std::int64_t step = m.integer("step");
  const ByteView data = m.bytes("data");
  const bool sane = width >= 1 && height >= 1 && width <= kLargest && height <= kLargest;
  const std::int64_t least = sane ? rowBytes(*e, width) : 0;
  // The planes of the colours follow the luminance.
  const std::int64_t colours =
      sane && e->half_planes > 2 ? (width * height * (e->half_planes - 2)) / 2 : 0;
  if (sane && step < least && e->packing == Packing::none && (e->bits == 10 || e->bits == 12)) {
    throw BagError("image of " + std::string(name.substr(0, 40)) + " has " + std::to_string(step) +
                   " bytes a row, which is not 16 bits a pixel; packed ones are called " +
                   std::to_string(e->bits) + "p or " + std::to_string(e->bits) + "packed");
  }
  if (!sane || step < least || step > INT64_MAX / kLargest ||
      (height - 1) * step + least + colours > static_cast<std::int64_t>(data.size)) {
    throw BagError("image of " + std::to_string(width) + "x" + std::to_string(height) +
                   " pixels, " + std::to_string(step) + " bytes a row, has only " +
                   std::to_string(data.size) + " bytes");
  }
  RawPixels out;
  out.demosaic = e->demosaic;
  const int w = static_cast<int>(width), h = static_cast<int>(height);
  if (e->packing != Packing::none) {
    out.pixels = unpacked(*e, data, w, h, step);
    return out;
  }
  // OpenCV takes no pointer to what is not to change.
  out.pixels =
      cv::Mat(h, w, e->type, const_cast<std::uint8_t*>(data.data), static_cast<std::size_t>(step));
  if (out.pixels.elemSize1() > 1) out.pixels = aligned(out.pixels, m.integer("is_bigendian") != 0);
  if (e->convert != kNo) {
    cv::Mat converted;
    cv::cvtColor(out.pixels, converted, e->convert);
    out.pixels = converted;
  }
  const int depth = out.pixels.depth();
  if (depth != CV_8U && depth != CV_16U && depth != CV_32F) {
    cv::Mat real;
    out.pixels.convertTo(real, CV_32F);
    out.pixels = real;
  }
  return out;
}

}  // namespace vir::bag
