#pragma once
/// A line per reading, e.g. from an Arduino:
///   IMU,<device_us>,<ax>,<ay>,<az>,<gx>,<gy>,<gz>*<checksum>
///   IMU,1234567,0.012,-0.034,9.806,0.001,0.002,-0.003*4E
/// device_us: the device's clock in microseconds, counting from 0 again after 2^32 (as micros()
/// does); specific force in m/s^2, rates in rad/s, with or without exponent; checksum: exclusive or
/// of all characters before the *, two hexadecimal digits.
#include "imu_parser.h"
#include "line_assembler.h"

namespace vir::serial_imu {

class TextParser : public ImuParser {
 public:
  static constexpr std::size_t kLongestLine = 256;
  explicit TextParser(const ImuLimits& limits) : ImuParser(limits), lines_(kLongestLine) {}
  std::string name() const override { return "text"; }
  void feed(const std::uint8_t* bytes, std::size_t size, std::vector<ImuReading>* out) override;
  void reset() override { lines_.reset(); }
  std::size_t buffered() const override { return lines_.buffered(); }
  TimeNs clockWrap() const override { return (TimeNs{1} << 32) * 1000; }

 private:
  LineAssembler lines_;
  std::vector<LineAssembler::Line> batch_;
};

}  // namespace vir::serial_imu
