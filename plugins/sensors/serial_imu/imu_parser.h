#pragma once
/// Inertial readings out of the bytes of a device. A parser is a pure function of the bytes fed to
/// it: in which pieces they come does not matter. Memory is bounded whatever the bytes are.
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "vir/core/time.h"

namespace vir::serial_imu {

struct ImuReading {
  TimeNs device_time = 0;            ///< on the device's clock, see clockWrap()
  std::array<double, 3> acc_m_s2{};  ///< specific force, sensor axes
  std::array<double, 3> gyro_rad_s{};
};

struct ParserCounters {
  long messages = 0;                ///< valid lines or frames
  long readings = 0;                ///< handed out
  long corrupt = 0;                 ///< lines or frames that are not as they must be
  long implausible = 0;             ///< beyond the limits
  long ignored = 0;                 ///< valid, but no inertial reading of the source in use
  long incomplete = 0;              ///< the device says that not all six values are new
  long lost = 0;                    ///< frames missing by the sequence numbers
  long other_text = 0;              ///< lines of no known kind
  std::uint64_t skipped_bytes = 0;  ///< between frames
};

/// A reading with a larger value is not handed out.
struct ImuLimits {
  double acc_m_s2 = 320;   ///< about 32 g
  double gyro_rad_s = 80;  ///< about 4500 deg/s
};

class ImuParser {
 public:
  explicit ImuParser(const ImuLimits& limits) : limits_(limits) {}
  virtual ~ImuParser() = default;

  virtual std::string name() const = 0;
  /// Adds the readings that these bytes complete to `out`.
  virtual void feed(const std::uint8_t* bytes, std::size_t size, std::vector<ImuReading>* out) = 0;
  /// The connection was interrupted: forgets the message begun. Counters stay.
  virtual void reset() = 0;
  virtual std::size_t buffered() const = 0;
  /// The device's clock starts again at 0 after this [ns]; 0 = never.
  virtual TimeNs clockWrap() const = 0;
  const ParserCounters& counters() const { return counters_; }

 protected:
  void give(const ImuReading& reading, std::vector<ImuReading>* out);

  ImuLimits limits_;
  ParserCounters counters_;
};

/// What MAVLink messages to take; see mavlink_parser.h.
struct MavlinkOptions {
  std::string message = "auto";  ///< auto, highres, scaled, raw
  int system_id = 0;             ///< 0 = that of the first reading
};

/// `protocol`: text, binary, mavlink. Throws std::invalid_argument for another name.
std::unique_ptr<ImuParser> makeParser(const std::string& protocol, const ImuLimits& limits,
                                      const MavlinkOptions& mavlink);

}  // namespace vir::serial_imu
