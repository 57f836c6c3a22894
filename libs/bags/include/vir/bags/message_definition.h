#pragma once
/// Types of messages, read from the text that recordings carry.
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "vir/bags/bag_reader.h"

namespace vir::bags {

enum class Kind {
  boolean,
  int8,
  uint8,
  int16,
  uint16,
  int32,
  uint32,
  int64,
  uint64,
  float32,
  float64,
  text,
  wide_text,
  time,
  duration,
  message
};

struct MessageType;

struct Field {
  std::string name;
  Kind kind = Kind::uint8;
  const MessageType* type = nullptr;  ///< of kind `message`
  bool array = false;
  std::uint64_t fixed_count = 0;  ///< of an array whose length is in its type; 0: in the bytes
};

struct MessageType {
  std::string name;  ///< package/Type
  std::vector<Field> fields;
  /// Bytes on the wire of ROS 1 where all messages have as many (at most kEndless), else 0.
  std::uint64_t ros1_size = 0;
  bool ros1_fixed = false;
};

/// A type with all that are in it.
class Definition {
 public:
  /// `text`: the type itself, then after lines of `===` the types in it, each behind a line
  /// `MSG: package/Type`. A type whose description is missing is taken from the known ones. Throws
  /// BagError naming the line.
  static std::shared_ptr<const Definition> parse(const std::string& type, const std::string& text,
                                                 Wire wire);
  /// From the file's text, or where it has none from the known types. Throws BagError.
  static std::shared_ptr<const Definition> of(const Channel& channel);

  const MessageType& root() const { return *types_.front(); }
  Wire wire() const { return wire_; }

 private:
  friend class DefinitionParser;
  std::vector<std::unique_ptr<MessageType>> types_;
  Wire wire_ = Wire::unknown;
};

/// The text of a standard type without those in it; empty if it is not known.
std::string_view standardDefinition(std::string_view type, Wire wire);

}  // namespace vir::bags
