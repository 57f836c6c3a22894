#include "imu_options.h"

namespace vir::serial_imu {

void describe(OptionVisitor& v, ImuOptions& o) {
  v.section("serial_imu", "Inertial readings of a serial IMU or an autopilot");
  v.value("port", o.source.port, "/dev/ttyACM0, tcp://host:port or udp://:port");
  v.value("baud", o.source.baud, {1200, 4000000}, "rate of a serial port");
  v.choice("protocol", o.protocol, {"text", "binary", "mavlink"}, "what the device speaks");
  v.choice("mavlink_message", o.mavlink.message, {"auto", "highres", "scaled", "raw"},
           "readings to take; auto: HIGHRES_IMU, else SCALED_IMU");
  v.value("mavlink_system", o.mavlink.system_id, {0, 255},
          "take readings of this system only; 0 = of the first to come");
  v.value("axes", o.axes,
          "sensor axes along the body's x, y, z; `x -y -z` turns forward-right-down (MAVLink) to "
          "forward-left-up");
  v.choice("stamp", o.stamp, {"device", "arrival"},
           "time of a reading: the device's clock brought to the host's, or when it arrived");
  v.value("latency_s", o.latency_s, {0, 10}, "taken off every stamp: from measuring to arrival");
  v.value("max_acc_m_s2", o.limits.acc_m_s2, {1, 1e6}, "larger readings are counted and dropped");
  v.value("max_gyro_rad_s", o.limits.gyro_rad_s, {0.1, 1e6},
          "larger readings are counted and dropped");
  v.value("silence_s", o.source.silence_s, {0, 3600},
          "report when nothing comes for so long (TCP: connect again); 0 = never");
}

}  // namespace vir::serial_imu
