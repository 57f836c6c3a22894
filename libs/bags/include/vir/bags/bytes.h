#pragma once
/// Bytes that belong to somebody else, and reading them with every length checked.
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace vir::bags {

/// A recording or a message cannot be read: what() says what, where and what to do.
class BagError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct ByteView {
  const std::uint8_t* data = nullptr;
  std::size_t size = 0;

  std::string_view text() const { return {reinterpret_cast<const char*>(data), size}; }
};

using Bytes = std::vector<std::uint8_t>;

/// A number stored with its lowest byte first.
template <typename T>
T littleEndian(const std::uint8_t* bytes) {
  static_assert(std::is_integral_v<T>, "whole numbers only");
  std::uint64_t v = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) v |= static_cast<std::uint64_t>(bytes[i]) << (8 * i);
  return static_cast<T>(v);
}

/// From left to right. Nothing is read beyond the end: functions return false then.
class ByteCursor {
 public:
  explicit ByteCursor(ByteView view) : rest_(view) {}

  std::size_t left() const { return rest_.size; }
  bool take(std::uint64_t size, ByteView* out) {
    if (size > rest_.size) return false;
    *out = {rest_.data, static_cast<std::size_t>(size)};
    rest_.data += size;
    rest_.size -= static_cast<std::size_t>(size);
    return true;
  }
  template <typename T>
  bool number(T* out) {
    ByteView bytes;
    if (!take(sizeof(T), &bytes)) return false;
    *out = littleEndian<T>(bytes.data);
    return true;
  }
  /// A length of 4 bytes, then so many.
  bool block(ByteView* out) {
    std::uint32_t size = 0;
    return number(&size) && take(size, out);
  }

 private:
  ByteView rest_;
};

}  // namespace vir::bags
