#pragma once
/// JSON lines of uwb-core (Apache Mynewt):
///   {"utime": 1234567, "uid": 4660, "ouid": 22136, "raz": [1.484], "rssi": [-79.3], "los": [1.0]}
/// uid: the tag, ouid: the other end, raz: range [m] and, on some boards, two angles; utime: us of
/// the device. (?) los: read as the certainty of a line of sight, above 0.5 = there is one. rssi,
/// los and utime may be missing; a key said twice makes the line invalid. And of our own, for tags
/// that only listen (TDoA), since no such device's protocol is documented:
///   {"utime": 1234567, "uid": 4660, "ouid": 22136, "ruid": 7, "tdoa": [-1.484]}
/// tdoa: the range to ouid less that to ruid, the reference [m], of either sign.
#include "range_parser.h"

namespace vir::uwb {

class JsonParser : public LineRangeParser {
 public:
  using LineRangeParser::LineRangeParser;
  std::string name() const override { return "json"; }
  bool clockTrusted() const override { return true; }

 protected:
  Verdict parseLine(std::string_view line, std::vector<RangeReading>* out) override;
};

}  // namespace vir::uwb
