#pragma once
/// A frame of 34 bytes per reading, little-endian:
///   0  A5 5A
///   2  01           kind: inertial reading
///   3  u8           sequence number, so that lost frames are noticed
///   4  u32          device clock [us], counting from 0 again after 2^32
///   8  3 x f32      specific force x, y, z [m/s^2]
///   20 3 x f32      rate x, y, z [rad/s]
///   32 u16          CRC-16/CCITT-FALSE (0x1021, start 0xFFFF) of bytes 2 to 31
#include "frame_buffer.h"
#include "imu_parser.h"

namespace vir::serial_imu {

class BinaryParser : public ImuParser {
 public:
  static constexpr std::size_t kFrameSize = 34;
  explicit BinaryParser(const ImuLimits& limits) : ImuParser(limits), frames_(kFrameSize) {}
  std::string name() const override { return "binary"; }
  void feed(const std::uint8_t* bytes, std::size_t size, std::vector<ImuReading>* out) override;
  void reset() override;
  std::size_t buffered() const override { return frames_.size(); }
  TimeNs clockWrap() const override { return (TimeNs{1} << 32) * 1000; }

 private:
  void take(const std::uint8_t* frame, std::vector<ImuReading>* out);

  FrameBuffer frames_;
  int last_sequence_ = -1;
};

}  // namespace vir::serial_imu
