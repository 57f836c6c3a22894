#pragma once
/// MAVLink 2 (and 1) from an autopilot: HIGHRES_IMU (105, SI units), SCALED_IMU (26, mG and mrad/s)
/// and RAW_IMU (27, no units: taken as those of SCALED_IMU, as ArduPilot sends it, only where it is
/// asked for). All others pass unlooked at. Vectors are in the autopilot's axes: x forward, y
/// right, z down.
///
/// A frame counts if its CRC is right, which covers a byte that stands for the message's
/// definition. MAVLink 2 cuts zeros off the end of a payload; they are put back. Signed frames are
/// taken without checking the signature. (Sequence numbers run over all messages, also those we do
/// not know, so they cannot tell how many readings were lost.)
///
/// With `auto` the first of the messages to come is taken, and HIGHRES_IMU instead once it comes.
/// One system's readings are taken, the first one's if none is named, and of that one component's.
#include "frame_buffer.h"
#include "imu_parser.h"

namespace vir::serial_imu {

class MavlinkParser : public ImuParser {
 public:
  MavlinkParser(const ImuLimits& limits, const MavlinkOptions& options);
  std::string name() const override { return "mavlink"; }
  void feed(const std::uint8_t* bytes, std::size_t size, std::vector<ImuReading>* out) override;
  void reset() override { frames_.clear(); }
  std::size_t buffered() const override { return frames_.size(); }
  /// Of the message in use: SCALED_IMU counts milliseconds in 32 bits.
  TimeNs clockWrap() const override;
  /// The message in use; 0 = none yet.

 private:
  struct Frame {
    int message = 0, system = 0, component = 0;
    std::size_t payload = 0, payload_size = 0, size = 0;
  };
  static bool header(const std::uint8_t* p, std::size_t n, Frame* frame, bool* impossible);
  long look(const std::uint8_t* p, std::size_t n);
  void take(const std::uint8_t* p, std::vector<ImuReading>* out);
  bool wanted(const Frame& frame);

  FrameBuffer frames_;
  MavlinkOptions options_;
  int in_use_ = 0;   ///< message number
  int source_ = -1;  ///< system and component
};

}  // namespace vir::serial_imu
