#pragma once
/// What emulated devices send, one encoder per protocol: the counterpart of the drivers' parsers
/// (plugins/sensors/uwb, plugins/sensors/serial_imu), against which they are tested.
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "vir/core/time.h"

namespace vir::emulator {

struct RangeItem {
  std::int64_t id = 0;
  double range_m = 0;
  /// Set: a difference (TDoA), the range to `id` less that to this anchor.
  std::optional<std::int64_t> reference = std::nullopt;
};

/// Ranges measured together.
struct RangeMessage {
  TimeNs device_time = 0;  ///< >= 0, on the device's clock; wraps as the device's does
  int own_id = 0;
  unsigned sequence = 0;
  std::vector<RangeItem> items;
};

/// What another node has sent, of at most 1024 bytes.
struct DataMessage {
  int own_id = 0, sender = 0;
  std::string bytes;
};

struct ImuMessage {
  TimeNs device_time = 0;
  unsigned sequence = 0;
  std::array<double, 3> acc_m_s2{}, gyro_rad_s{};
};

// Each throws std::invalid_argument for what the protocol cannot say.
std::string encodeDwm1001(const RangeMessage& m);     ///< `lec` line; cm
std::string encodeDwm1001Tlv(const RangeMessage& m);  ///< answer to a request; mm
std::string encodeTrek1000(const RangeMessage& m);    ///< ids 0 to 7; mm
std::string encodeAtRange(const RangeMessage& m);     ///< up to 8 ranges; cm
std::string encodeQm33(const RangeMessage& m);        ///< cm
std::string encodeNlink(const RangeMessage& m);       ///< NodeFrame3, ids up to 255; mm
std::string encodeNlinkData(const DataMessage& m);    ///< NodeFrame0
std::string encodeArduino(const RangeMessage& m);     ///< a line per range; mm
std::string encodeJson(const RangeMessage& m);        ///< a line per range or difference; um

std::string encodeImuText(const ImuMessage& m);
std::string encodeImuBinary(const ImuMessage& m);
std::string encodeMavlinkHighres(const ImuMessage& m);  ///< MAVLink 2, system 1, component 1
std::string encodeMavlinkScaled(const ImuMessage& m);   ///< mG and mrad/s in 16 bits

/// Protocols by the names that the drivers use (IMU: text, binary, mavlink, mavlink_scaled).
using RangeEncoder = std::string (*)(const RangeMessage&);
using ImuEncoder = std::string (*)(const ImuMessage&);
/// nullptr for an unknown name.
RangeEncoder rangeEncoder(const std::string& protocol);
ImuEncoder imuEncoder(const std::string& protocol);
/// For help texts.
std::vector<std::string> rangeProtocols();
std::vector<std::string> imuProtocols();

}  // namespace vir::emulator
