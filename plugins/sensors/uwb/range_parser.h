#pragma once
/// Ranges out of the bytes a UWB device sends. A parser is a pure function of the bytes fed to it:
/// in which pieces they come does not matter. Memory is bounded whatever the bytes are.
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "line_assembler.h"
#include "vir/core/time.h"

namespace vir::uwb {

struct RangeReading {
  std::int64_t responder = 0;       ///< the other end's id, as the device numbers it
  std::optional<std::int64_t> own;  ///< id of the tag that measured, where it is told
  /// Set: a difference (TDoA), the range to the responder less that to this anchor, either sign.
  std::optional<std::int64_t> reference;
  double range_m = 0;                 ///< as measured: no bias is taken off
  std::optional<double> rssi_dbm;     ///< received power
  std::optional<double> fp_rssi_dbm;  ///< power of the first path
  std::optional<bool> line_of_sight;  ///< a hint at best
  std::optional<TimeNs> device_time;  ///< on the device's clock, see clockWrap()
};

/// What became of the input. Every range of a valid message is counted once: in ranges, failed or
/// implausible.
struct ParserCounters {
  long messages = 0;       ///< valid lines or frames, with ranges or without
  long ranges = 0;         ///< handed out
  long failed = 0;         ///< the device says that it did not get the range (or it is 0)
  long implausible = 0;    ///< outside the limits
  long corrupt = 0;        ///< lines or frames that are not as they must be
  long fragments = 0;      ///< a first line without its beginning
  long ignored = 0;        ///< valid, but not about ranges of this device (positions, other nodes)
  long other_text = 0;     ///< lines of no known kind (prompts, banners)
  long device_errors = 0;  ///< the device reports an error instead of an answer
  std::uint64_t skipped_bytes = 0;  ///< between binary frames

  ParserCounters& operator+=(const ParserCounters& o);
};

/// What another node has sent beside its ranges.
struct NodeData {
  std::int64_t sender = 0;  ///< id of its radio
  std::vector<std::uint8_t> bytes;
};

/// A range outside is not handed out [m].
struct RangeLimits {
  double min_m = 0.05;
  double max_m = 300;
};

class RangeParser {
 public:
  explicit RangeParser(const RangeLimits& limits) : limits_(limits) {}
  virtual ~RangeParser() = default;

  /// Name of the protocol in an ini.
  virtual std::string name() const = 0;
  /// Grows whenever name() may have changed.
  virtual long choices() const { return 0; }
  /// Adds the ranges that these bytes complete to `out`.
  virtual void feed(const std::uint8_t* bytes, std::size_t size,
                    std::vector<RangeReading>* out) = 0;
  /// The connection was interrupted: forgets the message begun. Counters stay.
  virtual void reset() = 0;
  /// Bytes held for a message begun.
  virtual std::size_t buffered() const = 0;
  /// The device's clock starts again at 0 after this [ns]; 0 = never.
  virtual TimeNs clockWrap() const { return 0; }
  /// True if device_time is known to be the time of the range (documented, in known units).
  virtual bool clockTrusted() const { return false; }
  virtual const ParserCounters& counters() const { return counters_; }
  /// What other nodes have sent, of the bytes fed since the last call.
  virtual std::vector<NodeData> takeData() { return std::exchange(data_, {}); }

 protected:
  /// Hands out or counts one range, or difference of ranges, of a valid message.
  void give(const RangeReading& reading, std::vector<RangeReading>* out);

  RangeLimits limits_;
  ParserCounters counters_;
  std::vector<NodeData> data_;
};

/// Protocols that are lines of text.
class LineRangeParser : public RangeParser {
 public:
  static constexpr std::size_t kLongestLine = 1024;
  explicit LineRangeParser(const RangeLimits& limits) : RangeParser(limits), lines_(kLongestLine) {}
  void feed(const std::uint8_t* bytes, std::size_t size, std::vector<RangeReading>* out) override;
  void reset() override { lines_.reset(); }
  std::size_t buffered() const override { return lines_.buffered(); }

 protected:
  enum class Verdict { message, ignored, other, corrupt, unfinished, device_error };
  /// Judges one line as a whole; calls give() only for a valid one.
  virtual Verdict parseLine(std::string_view line, std::vector<RangeReading>* out) = 0;

 private:
  LineAssembler lines_;
  std::vector<LineAssembler::Line> batch_;
};

/// Names of all protocols, without "auto".
const std::vector<std::string>& protocolNames();

/// By name, or "auto" (auto_parser.h). Throws std::invalid_argument for another name.
std::unique_ptr<RangeParser> makeParser(const std::string& protocol, const RangeLimits& limits);

}  // namespace vir::uwb
