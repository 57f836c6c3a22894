#pragma once
/// Qorvo DWM1001 in its binary mode, experimental: answers to the request 0C 00 (`dwm_loc_get`),
///   40 01 00 | 41 0D x y z (i32, mm) quality | 49 len count, count x {id u16, mm u32, quality u8,
///   13 bytes: position and quality of the anchor}
/// (?) The order of the parts and the 49 part are from one source only. There is no checksum: every
/// length, the count and the qualities (0..100) must be right, no anchor may come twice.
#include "frame_parser.h"

namespace vir::uwb {

class Dwm1001TlvParser : public FrameRangeParser {
 public:
  using FrameRangeParser::FrameRangeParser;
  std::string name() const override { return "dwm1001_tlv"; }

 protected:
  Look look(const std::uint8_t* bytes, std::size_t size) const override;
  void parseFrame(const std::uint8_t* bytes, std::size_t size,
                  std::vector<RangeReading>* out) override;
};

}  // namespace vir::uwb
