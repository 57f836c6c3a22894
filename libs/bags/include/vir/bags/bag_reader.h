#pragma once
/// Recordings of ROS, whatever file they are in, as one stream of messages. Memory does not grow
/// with the length of the recording, no index is needed, and files that end early give what they
/// have.
#include <algorithm>
#include <cstdint>
#include <deque>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "vir/bags/bytes.h"
#include "vir/bags/message_sink.h"
#include "vir/core/time.h"

namespace vir::bags {

/// How the fields of a message lie in its bytes.
enum class Wire { ros1, cdr, unknown };

/// A topic with the type of its messages.
struct Channel {
  std::string topic;
  std::string type;  ///< package/Type, also where the file says package/msg/Type
  /// Text of the type and of those in it; none if the file has none. Topics of a type share it.
  std::shared_ptr<const std::string> definition;
  Wire wire = Wire::unknown;
  std::string encoding;    ///< as the file calls it, e.g. "cdr" or "protobuf"
  Metadata metadata = {};  ///< of MCAP
};

struct BagMessage {
  const Channel* channel = nullptr;  ///< lives as long as the reader
  TimeNs received = 0;               ///< when the recorder got it [ns since 1970]
  ByteView data;                     ///< until the next call of next()
};

class BagReader {
 public:
  virtual ~BagReader() = default;
  /// In the order of the file. False at its end, or where it cannot be read further; then
  /// damage() says why. Throws BagError only for what concerns the machine (no memory, no file).
  virtual bool next(BagMessage* message) = 0;
  /// Share of the file that has been read, 0..1.
  virtual double progress() const = 0;
  /// What is wrong with the file so far, one line each.
  const std::vector<std::string>& damage() const { return damage_; }
  /// What else is to be known of it, and is no fault of what can be read, one line each.
  const std::vector<std::string>& notes() const { return notes_; }

 protected:
  /// A time of receipt as a file says it, which may be anything: the difference of two always fits
  /// (until 2116 nothing is changed).
  static TimeNs receivedAt(std::int64_t ns) {
    constexpr TimeNs kMost = std::numeric_limits<TimeNs>::max() / 2;
    return std::clamp<std::int64_t>(ns, -kMost, kMost);
  }
  /// Kept to the first few.
  void report(const std::string& text) {
    if (damage_.size() < 20) damage_.push_back(text);
  }
  void note(const std::string& text) {
    if (notes_.size() < 20) notes_.push_back(text);
  }
  /// All that another one, which has read a part of this, says.
  void takeOver(const BagReader& part) {
    for (const std::string& d : part.damage()) report(d);
    for (const std::string& n : part.notes()) note(n);
  }

 private:
  std::vector<std::string> damage_, notes_;
};

enum class BagKind { none, ros1, mcap, sqlite, folder, ros1_folder };

/// By content; `folder` is one with files of ROS 2 in it, `ros1_folder` one with bags of ROS 1 and
/// none of ROS 2. Does not throw.
BagKind bagKindOf(const std::string& path);

/// Throws BagError if there is nothing to read at all.
std::unique_ptr<BagReader> openBag(const std::string& path);
/// The same for a file that is in memory already, which must outlive the reader; `name` stands for
/// it in messages.
std::unique_ptr<BagReader> openBag(ByteView bytes, const std::string& name);

/// `package/msg/Type` without the `msg`.
std::string shortTypeName(const std::string& type);

}  // namespace vir::bags
