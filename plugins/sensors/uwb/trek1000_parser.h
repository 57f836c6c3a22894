#pragma once
/// Decawave TREK1000 and boards with its firmware (HR-RTLS1, BU01): lines
///   mc MASK R0 R1 R2 R3 LOG SEQ TIME role:  mc 0f 00000663 000005a3 00000512 000004cb 095f c1
///   00024bed a0:0
/// in hexadecimal, ranges in mm, range i valid if bit i of MASK is set; `t1:0` = told by tag 1 to
/// anchor 0 (the range is tag 1's in any case; R0..R3 are those to anchors 0 to 3). Variants have
/// eight ranges, and -100 x RSSI [dBm] at the end. `mr` lines repeat the ranges without the board's
/// own correction, `ma` lines are between anchors: both are checked, and not used. (?) TIME: ms
/// since the tag's start; not confirmed, so it is not used as a clock by default.
#include "range_parser.h"

namespace vir::uwb {

class Trek1000Parser : public LineRangeParser {
 public:
  using LineRangeParser::LineRangeParser;
  std::string name() const override { return "trek1000"; }
  TimeNs clockWrap() const override { return (TimeNs{1} << 32) * 1000000; }

 protected:
  Verdict parseLine(std::string_view line, std::vector<RangeReading>* out) override;
};

}  // namespace vir::uwb
