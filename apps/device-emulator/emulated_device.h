#pragma once
/// One device: messages at their times, damaged or interrupted if asked for.
#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "emulated_air.h"
#include "messages.h"
#include "pty_port.h"
#include "vir/core/random.h"

namespace vir::emulator {

struct FaultOptions {
  double garbage = 0;                           ///< share of messages with random bytes before them
  double corrupt = 0;                           ///< share of messages with one byte changed
  double unplug_every_s = 0, unplug_for_s = 1;  ///< of recorded time; 0 = never
  int seed = 1;
};

struct DeviceOptions {
  std::string protocol;
  std::string link;
  double clock_offset_s = 1000, clock_drift_ppm = 0;  ///< of the device against the recording
  bool shell = false;                                 ///< a DWM1001 that is silent until told `lec`
  int own_id = 9;                                     ///< of a radio
  AirOptions air;                                     ///< between radios that carry data (nlink)
  FaultOptions faults;
};

/// What became of the messages; each is counted once, in `sent`, `damaged`, `unheard`, `unplugged`,
/// `refused` or `overrun`.
struct DeviceCounts {
  long messages = 0;   ///< that the recording had
  long sent = 0;       ///< as they should be, to a reader
  long damaged = 0;    ///< sent with a byte changed
  long unheard = 0;    ///< nobody had the port open
  long unplugged = 0;  ///< while pulled out
  long refused = 0;    ///< beyond what the protocol can say
  long overrun = 0;    ///< the reader was too slow
  long garbage_bytes = 0;
  long unplugs = 0;
};

class EmulatedDevice {
 public:
  explicit EmulatedDevice(const DeviceOptions& options);
  virtual ~EmulatedDevice() = default;

  void plugIn() { port_.plugIn(); }
  /// True once a reader has it open and has had time to set it up. `now_s` of a steady clock.
  bool heard(double now_s);
  /// Sends what waits, hears what the reader says, pulls out and plugs in: call it often. `t` =
  /// recorded time since the start.
  virtual void service(TimeNs t, double now_s);
  const PtyPort& port() const { return port_; }
  const DeviceOptions& options() const { return options_; }
  const DeviceCounts& counts() const { return counts_; }

 protected:
  /// Device time of recorded time `t`.
  TimeNs deviceTime(TimeNs t) const;
  /// One message, encoded; empty = it could not be.
  void send(std::string message, double now_s);
  /// Bytes the reader sent, for devices that listen.
  virtual void hear(const std::string& bytes, double now_s);
  bool streaming_ = true;
  void push(const std::string& bytes);
  DeviceCounts counts_;

 private:
  void plugAndUnplug(TimeNs t, double now_s);

  DeviceOptions options_;
  PtyPort port_;
  Random random_;
  std::string pending_, line_;
  double reader_since_s_ = -1, pull_at_s_ = -1;
  TimeNs next_change_ = 0;
};

class EmulatedRadio : public EmulatedDevice {
 public:
  /// Throws std::invalid_argument for an unknown protocol.
  explicit EmulatedRadio(const DeviceOptions& options);
  void play(TimeNs t, const RangeItem& range, double now_s);
  void service(TimeNs t, double now_s) override;
  /// Ranges kept for a binary DWM1001 that nobody asks.
  long unasked() const { return static_cast<long>(waiting_.size()); }
  /// Packets of its reader that went on the air, and packets of others that came from there.
  long dataOut() const { return data_out_; }
  long dataIn() const { return data_in_; }

 protected:
  void hear(const std::string& bytes, double now_s) override;

 private:
  RangeEncoder encode_;
  unsigned sequence_ = 0;
  std::deque<RangeItem> waiting_;
  std::unique_ptr<EmulatedAir> air_;
  long data_out_ = 0, data_in_ = 0;
  char last_byte_ = 0;
};

class EmulatedImu : public EmulatedDevice {
 public:
  explicit EmulatedImu(const DeviceOptions& options);
  void play(TimeNs t, const ImuMessage& reading, double now_s);

 private:
  ImuEncoder encode_;
  unsigned sequence_ = 0;
};

}  // namespace vir::emulator
