#pragma once
/// Holds bytes until a binary frame is complete and finds the next one after bytes that belong to
/// none.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace vir::serial_imu {

class FrameBuffer {
 public:
  /// What stands at the front: bytes of a frame (> 0), kNone = no frame begins here, kMore = cannot
  /// be told yet (never with `longest` bytes there).
  static constexpr long kNone = 0, kMore = -1;

  explicit FrameBuffer(std::size_t longest) : longest_(longest) {}

  /// Calls look(bytes, size) -> long as above and, for each frame, take(bytes, size). Returns how
  /// many bytes belonged to no frame.
  template <typename Look, typename Take>
  std::size_t feed(const std::uint8_t* bytes, std::size_t size, Look look, Take take) {
    constexpr std::size_t kPiece = 1024;
    std::size_t skipped = 0;
    for (std::size_t done = 0; done < size;) {
      const std::size_t n = std::min(kPiece, size - done);
      buffer_.insert(buffer_.end(), bytes + done, bytes + done + n);
      done += n;
      std::size_t at = 0;
      while (at < buffer_.size()) {
        const std::size_t left = buffer_.size() - at;
        const long found = look(buffer_.data() + at, left);
        if (found == kMore && left < longest_) break;
        if (found > 0) {
          take(buffer_.data() + at, static_cast<std::size_t>(found));
          at += static_cast<std::size_t>(found);
        } else {
          ++skipped;
          ++at;
        }
      }
      buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(at));
    }
    return skipped;
  }
  void clear() { buffer_.clear(); }
  std::size_t size() const { return buffer_.size(); }

 private:
  std::size_t longest_;
  std::vector<std::uint8_t> buffer_;
};

}  // namespace vir::serial_imu
