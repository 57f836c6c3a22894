#pragma once
/// What is said to devices that do not send unasked. Pure: time and bytes in, bytes to send out.
#include <cstddef>
#include <cstdint>
#include <string>

namespace vir::uwb {

/// Gets a DWM1001 to print its ranges. Its command `lec` is a toggle, so the stream is watched
/// first, and only where nothing comes the shell is woken (two returns) and, at its prompt, told
/// `lec`. Tried again, less and less often, until ranges come.
class Dwm1001Dialogue {
 public:
  /// Seconds on a steady clock; `messages` = range messages seen so far. Returns what to send.
  std::string step(double now_s, long messages);
  /// Looks for the prompt.
  void hear(const std::uint8_t* bytes, std::size_t size);
  /// True once something was said on this connection.
  bool engaged() const { return engaged_; }
  /// The connection is new.
  void restart();

 private:
  enum class Phase { listening, waking, commanded };
  void enter(Phase phase, double now_s, double for_s);

  Phase phase_ = Phase::listening;
  bool begun_ = false, engaged_ = false;
  double until_s_ = 0, patience_s_ = 0;
  long messages_ = 0;
  std::string tail_;
  bool prompt_ = false;
};

/// Asks a DWM1001 in binary mode for its ranges at a fixed rate.
class TlvPolling {
 public:
  explicit TlvPolling(double hz) : period_s_(1 / hz) {}
  std::string step(double now_s);

 private:
  double period_s_, next_s_ = 0;
};

}  // namespace vir::uwb
