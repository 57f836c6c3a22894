#include "whole_png.h"

#include <zlib.h>

#include <cstring>

#include "image_head.h"

namespace vir {
namespace {

std::uint32_t bigEndian(const std::uint8_t* b) {
  return static_cast<std::uint32_t>(b[0]) << 24 | static_cast<std::uint32_t>(b[1]) << 16 |
         static_cast<std::uint32_t>(b[2]) << 8 | b[3];
}

/// IHDR: 8 bits, grey (0) or true colour (2), deflate, no filter but PNG's own.
bool isPlain(const std::uint8_t* head) {
  return head[8] == 8 && (head[9] == 0 || head[9] == 2) && head[10] == 0 && head[11] == 0 &&
         head[12] <= 1;
}

}  // namespace

std::optional<PngSize> wholePlainPng(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t kMagic = 8, kAround = 12;  // length, name and checksum of a part
  constexpr std::uint32_t kLargest = 100'000;
  if (size < kMagic || std::memcmp(data, "\x89PNG\r\n\x1a\n", kMagic) != 0) return std::nullopt;
  if (!pixelsFit(data, size)) return std::nullopt;
  PngSize out;
  bool pixels = false;
  for (std::size_t at = kMagic; size - at >= kAround;) {
    const std::size_t length = bigEndian(data + at);
    if (length > size - at - kAround) return std::nullopt;
    const std::uint8_t* name = data + at + 4;
    const std::uint8_t* body = name + 4;
    const uLong sum = crc32(0, name, static_cast<uInt>(length + 4));
    if (sum != bigEndian(body + length)) return std::nullopt;
    const auto is = [&](const char* what) { return std::memcmp(name, what, 4) == 0; };
    const bool first = at == kMagic;
    if (is("IHDR") != first || is("tRNS")) return std::nullopt;
    if (first) {
      if (length != 13 || !isPlain(body)) return std::nullopt;
      const std::uint32_t width = bigEndian(body), height = bigEndian(body + 4);
      if (width < 1 || height < 1 || width > kLargest || height > kLargest) return std::nullopt;
      out = {static_cast<int>(width), static_cast<int>(height)};
    }
    pixels = pixels || (is("IDAT") && length > 0);
    if (is("IEND")) return pixels ? std::optional<PngSize>(out) : std::nullopt;
    at += length + kAround;
  }
  return std::nullopt;
}

}  // namespace vir
