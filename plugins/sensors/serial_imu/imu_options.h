#pragma once
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
  std::string axes = "x y z";  ///< see axesRotation()
  std::string stamp = "device";
  double latency_s = 0;
};

void describe(OptionVisitor& v, ImuOptions& o);

}  // namespace vir::serial_imu
