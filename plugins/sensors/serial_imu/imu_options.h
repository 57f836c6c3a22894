#pragma once
#include <array>
#include <string>

#include "byte_source.h"
#include "imu_parser.h"
#include "vir/core/options.h"

namespace vir::serial_imu {

/// Settings of a section with driver = SerialImu.
struct ImuOptions {
  ByteSourceOptions source;
  std::string protocol = "text";
  ImuLimits limits;
  MavlinkOptions mavlink;
  std::string axes = "x y z";  ///< see parseAxes()
  std::string stamp = "device";
  double latency_s = 0;
};

void describe(OptionVisitor& v, ImuOptions& o);

/// Which axis of the sensor, with which sign, points along each axis of the body.
struct Axes {
  std::array<int, 3> from = {0, 1, 2};
  std::array<double, 3> sign = {1, 1, 1};

  std::array<double, 3> toBody(const std::array<double, 3>& v_sensor) const {
    return {sign[0] * v_sensor[static_cast<std::size_t>(from[0])],
            sign[1] * v_sensor[static_cast<std::size_t>(from[1])],
            sign[2] * v_sensor[static_cast<std::size_t>(from[2])]};
  }
};

/// Three words: the sensor axis that the body's x, y, z is, e.g. "x -y -z" for a sensor whose y
/// points right and z down in a body with y left and z up. Throws std::invalid_argument for
/// anything that is not a rotation.
Axes parseAxes(const std::string& text);

}  // namespace vir::serial_imu
