#pragma once
/// Protocols of binary frames: holds bytes until a frame is complete, and finds the next one after
/// bytes that belong to none.
#include "range_parser.h"

namespace vir::uwb {

class FrameRangeParser : public RangeParser {
 public:
  using RangeParser::RangeParser;
  void feed(const std::uint8_t* bytes, std::size_t size, std::vector<RangeReading>* out) override;
  void reset() override { buffer_.clear(); }
  std::size_t buffered() const override { return buffer_.size(); }

 protected:
  enum class Outcome { frame, corrupt, none, need_more };
  struct Look {
    Outcome outcome = Outcome::none;
    /// Bytes of the frame. `corrupt` (it looked like a frame) and `none` drop one byte and look on
    /// from the next: in a damaged frame a good one may begin.
    std::size_t size = 0;
  };
  /// What stands at the front of `size` > 0 bytes. May ask for more only up to kLongestFrame bytes.
  static constexpr std::size_t kLongestFrame = 4096;
  virtual Look look(const std::uint8_t* bytes, std::size_t size) const = 0;
  /// A frame that look() found.
  virtual void parseFrame(const std::uint8_t* bytes, std::size_t size,
                          std::vector<RangeReading>* out) = 0;

 private:
  std::vector<std::uint8_t> buffer_;
};

/// Little-endian numbers at `p`.
inline std::uint16_t u16At(const std::uint8_t* p) {
  return static_cast<std::uint16_t>(p[0] | p[1] << 8);
}
inline std::uint32_t u32At(const std::uint8_t* p) {
  return static_cast<std::uint32_t>(p[0]) | static_cast<std::uint32_t>(p[1]) << 8 |
         static_cast<std::uint32_t>(p[2]) << 16 | static_cast<std::uint32_t>(p[3]) << 24;
}
inline std::int32_t i24At(const std::uint8_t* p) {
  const std::int32_t v = p[0] | p[1] << 8 | p[2] << 16;
  return v >= 0x800000 ? v - 0x1000000 : v;
}

}  // namespace vir::uwb
