#include "image_head.h"

#include <cstring>

namespace vir {
namespace {

constexpr std::uint64_t kAlwaysAllowed = 16'000'000;  // [px]
constexpr std::uint64_t kMostPerByte = 1032;          // deflate cannot pack more into a byte

struct Bytes {
  const std::uint8_t* data;
  std::size_t size;

  bool begin(std::size_t at, const char* with, std::size_t n) const {
    return at + n <= size && std::memcmp(data + at, with, n) == 0;
  }
  /// Of `n` bytes; 0 beyond the end.
  std::uint64_t number(std::size_t at, std::size_t n, bool big) const {
    if (at > size || n > size - at) return 0;
    std::uint64_t v = 0;
    for (std::size_t i = 0; i < n; ++i) v = v << 8 | data[at + (big ? i : n - 1 - i)];
    return v;
  }
};

/// Frame headers come after other segments, each with its length.
std::uint64_t pixelsOfJpeg(const Bytes& b) {
  std::size_t at = 2;
  while (at + 4 <= b.size && b.data[at] == 0xFF) {
    const std::uint8_t mark = b.data[at + 1];
    if (mark == 0xFF) {
      ++at;
      continue;
    }
    const bool frame = mark >= 0xC0 && mark <= 0xCF && mark != 0xC4 && mark != 0xC8 && mark != 0xCC;
    if (frame) return b.number(at + 5, 2, true) * b.number(at + 7, 2, true);
    if (mark == 0xDA) return 0;
    at += 2 + static_cast<std::size_t>(b.number(at + 2, 2, true));
  }
  return 0;
}

std::uint64_t pixelsOfTiff(const Bytes& b, bool big) {
  const auto head = static_cast<std::size_t>(b.number(4, 4, big));
  std::uint64_t width = 0, height = 0;
  const std::uint64_t entries = b.number(head, 2, big);
  for (std::size_t i = 0; i < entries && head + 2 + 12 * i < b.size; ++i) {
    const std::size_t at = head + 2 + 12 * i;
    const std::uint64_t tag = b.number(at, 2, big);
    const std::uint64_t value = b.number(at + 8, b.number(at + 2, 2, big) == 3 ? 2 : 4, big);
    if (tag == 256) width = value;
    if (tag == 257) height = value;
  }
  return width * height;
}

/// As claimed; 0: not known.
std::uint64_t pixelsOf(const Bytes& b) {
  if (b.begin(0, "\x89PNG", 4)) return b.number(16, 4, true) * b.number(20, 4, true);
  if (b.begin(0, "\xFF\xD8", 2)) return pixelsOfJpeg(b);
  if (b.begin(0, "II*\0", 4)) return pixelsOfTiff(b, false);
  if (b.begin(0, "MM\0*", 4)) return pixelsOfTiff(b, true);
  if (!b.begin(0, "BM", 2)) return 0;
  // A negative height stands for rows from the top.
  const auto height = static_cast<std::int32_t>(b.number(22, 4, false));
  const std::int64_t rows = height < 0 ? -std::int64_t{height} : height;
  return b.number(18, 4, false) * static_cast<std::uint64_t>(rows);
}

}  // namespace

bool pixelsFit(const std::uint8_t* bytes, std::size_t size) {
  return pixelsOf({bytes, size}) <= kAlwaysAllowed + kMostPerByte * size;
}

}  // namespace vir
