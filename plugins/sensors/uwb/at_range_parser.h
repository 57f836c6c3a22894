#pragma once
/// Makerfabs and Ai-Thinker boards (BU01, BU03, ESP32 UWB) with AT firmware:
///   AT+RANGE=tid:0,mask:01,seq:65,range:(92,0,0,0,0,0,0,0),rssi:(-79.31,...),ancid:(0,-1,...)
/// Ranges in cm in 4 or 8 slots; slot i holds a range if bit i of mask (hexadecimal, with or
/// without 0x) is set. `rssi`, `kx`, `ky` and `ancid` may be missing; without ancid the slot is the
/// anchor's id. Blanks after commas are allowed.
#include "range_parser.h"

namespace vir::uwb {

class AtRangeParser : public LineRangeParser {
 public:
  using LineRangeParser::LineRangeParser;
  std::string name() const override { return "at_range"; }

 protected:
  Verdict parseLine(std::string_view line, std::vector<RangeReading>* out) override;
};

}  // namespace vir::uwb
