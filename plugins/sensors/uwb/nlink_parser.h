#pragma once
/// Nooploop LinkTrack (protocol NLink), binary, little-endian, last byte = sum of all before it:
///   TagFrame0  55 01, 128 bytes: distances to anchors 0 to 7
///   NodeFrame2 55 04, NodeFrame3 55 05, NodeFrame5 55 08: a length, a fixed part, n nodes
///   NodeFrame0 55 02: a length, role, id, 4 reserved, a count, and per node role, id, u16 length
///   and
///              so many bytes that it has sent ("data transmission")
/// The sum is one byte only, so what else is known of a frame is checked too: the length against
/// the number of nodes, the roles, and in TagFrame0, which has no length, that its six floats are
/// numbers a gyro and an accelerometer can show. Distance 0 = not measured. A received power more
/// than 6 dB above that of the first path hints at no line of sight (?).
#include "frame_parser.h"

namespace vir::uwb {

class NlinkParser : public FrameRangeParser {
 public:
  using FrameRangeParser::FrameRangeParser;
  std::string name() const override { return "nlink"; }
  TimeNs clockWrap() const override { return (TimeNs{1} << 32) * 1000000; }
  bool clockTrusted() const override { return true; }

 protected:
  Look look(const std::uint8_t* bytes, std::size_t size) const override;
  void parseFrame(const std::uint8_t* bytes, std::size_t size,
                  std::vector<RangeReading>* out) override;

 private:
  static Look lookAtData(const std::uint8_t* bytes, std::size_t size);
  void parseDataFrame(const std::uint8_t* bytes);
  void parseTagFrame(const std::uint8_t* bytes, std::vector<RangeReading>* out);
};

}  // namespace vir::uwb
