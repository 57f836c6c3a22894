#pragma once
/// Examples of the Arduino DW1000 libraries: `from: 0xE29C\tRange: 1.484 m\tRX power: -67.19 dBm`
/// (id with or without 0x; tabs and blanks between the fields). No checksum: the whole line must be
/// as shown.
#include "range_parser.h"

namespace vir::uwb {

class ArduinoParser : public LineRangeParser {
 public:
  using LineRangeParser::LineRangeParser;
  std::string name() const override { return "dw1000_arduino"; }

 protected:
  Verdict parseLine(std::string_view line, std::vector<RangeReading>* out) override;
};

}  // namespace vir::uwb
