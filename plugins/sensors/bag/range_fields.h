#pragma once
/// Ranges have no standard message: where a number, an anchor and a time are in one of theirs.
#include <optional>
#include <string>
#include <vector>

#include "bag_options.h"
#include "vir/bags/message_view.h"
#include "vir/geometry/pose.h"

namespace vir::bag {

struct RangeFields {
  std::string list;  ///< of messages, one per range; empty: the message is one
  /// Paths within the message, or within an element of the list. `anchor` may be "" (see
  /// `fixed_anchor`) or, where `distance` is a list of numbers, a list of as many numbers or texts.
  std::string anchor, distance, stamp;
  std::string sigma;
  bool sigma_squared = false;
  bool asked = false;   ///< stamp or sigma were named by the user: they must be there
  std::string valid;    ///< a number or a boolean; 0: no range
  std::string antenna;  ///< a Point: antenna in the body [m]
  std::string place;    ///< a Point: where the anchor is, in a frame of its own [m]
  std::string name;     ///< a text: the anchor, where that is no number
  std::string tag;      ///< a number or a text: which of the robot's radios; empty: there is one
  std::optional<std::string> fixed_anchor;
  /// A number or a text: the anchor to which the range is less; set: differences of ranges (TDoA).
  std::string reference;
  double unit_m = 1;
};

/// One range as the message has it.
struct ReadRange {
  std::string anchor;     ///< as written: decimal, or text
  std::string reference;  ///< likewise; empty: a range
  double range_m = 0;
  std::string tag;     ///< as written; empty: not told
  double sigma_m = 0;  ///< 0: not given
  std::optional<TimeNs> stamp;
  std::optional<Vec3> antenna;
  std::optional<Vec3> place;  ///< of the anchor, in a frame of its own [m]
};

/// Of what our own export writes.
bool isOwnRange(const std::string& type);
/// What is known of a type of message, or empty.
std::optional<RangeFields> knownRangeFields(const std::string& type);
/// By what was asked for (`anchor,distance`, each perhaps `list[].field`; `#7` = always anchor 7;
/// then perhaps `unit=mm`, `stamp=field`, `sigma=field`, `valid=field`, `tag=field`,
/// `antenna=field`, `place=field`, `reference=field`), or of the known type.
/// `frame`: of the topic's messages, for a Range that names no anchor. Throws InputError.
RangeFields rangeFieldsOf(const TopicWish& wish, const std::string& type, const std::string& frame);
/// The fields that must be anchor and distance by their names, as `--topic range=` takes them, in a
/// type that is not known: of the message, of a list of messages in it, or two lists side by side.
/// Whole numbers are taken for millimetres. Empty: there is no such pair.
std::vector<std::string> guessRangeFields(const bags::MessageType& type);

/// Likewise of differences of ranges (TDoA), with the field of the reference anchor.
std::vector<std::string> guessDifferenceFields(const bags::MessageType& type);

/// Throws bags::BagError.
std::vector<ReadRange> readRanges(const bags::MessageView& message, const RangeFields& fields);

}  // namespace vir::bag
