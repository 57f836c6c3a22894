#pragma once
/// Fields of a message by their names, read from its bytes where they lie: nothing is copied, and
/// no type is compiled in.
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "vir/bags/message_definition.h"

namespace vir::bags {

/// Bytes of a message, walked from front to back. Throws BagError where they end before the message
/// does.
class WireCursor {
 public:
  /// Takes the head that CDR has. `wire` as in the definition.
  WireCursor(ByteView bytes, Wire wire);

  std::uint64_t unsignedNumber(std::size_t size);
  std::uint32_t count() { return static_cast<std::uint32_t>(unsignedNumber(4)); }
  ByteView take(std::uint64_t size);
  void align(std::size_t size);
  std::size_t left() const { return bytes_.size - at_; }
  bool cdr() const { return cdr_; }

  /// Past a whole field, or past one element of it.
  void skip(const Field& field);
  void skipElement(const Field& field);
  void skip(const MessageType& type);

 private:
  ByteView bytes_;
  std::size_t at_ = 0;
  bool cdr_ = false, big_ = false;
  std::size_t most_aligned_ = 8;
};

/// A message, or one within it. Paths: names with points between, e.g. "header.stamp". Functions
/// throw BagError where the bytes are damaged, and where the field is of another kind.
class MessageView {
 public:
  /// Both must outlive the view.
  MessageView(const Definition& definition, ByteView bytes)
      : type_(&definition.root()), cursor_(bytes, definition.wire()) {}

  const MessageType& type() const { return *type_; }
  bool has(std::string_view path) const { return typeOf(*type_, path) != nullptr; }
  /// The field's description, or nullptr.
  static const Field* typeOf(const MessageType& type, std::string_view path);

  double number(std::string_view path) const;
  /// Whole numbers of all 64 bits; others cut.
  std::int64_t integer(std::string_view path) const;
  std::string_view text(std::string_view path) const;
  /// ROS 1's time, ROS 2's message with seconds and nanoseconds; empty for anything else.
  std::optional<TimeNs> time(std::string_view path) const;
  /// A list of numbers, at most `most` of them.
  std::vector<double> numbers(std::string_view path, std::size_t most) const;
  /// A list of texts, at most `most` of them; they lie in the message's bytes.
  std::vector<std::string_view> texts(std::string_view path, std::size_t most) const;
  /// A list of bytes (uint8[]), not copied.
  ByteView bytes(std::string_view path) const;
  /// Each message of a list of messages; `path` is the list.
  void each(std::string_view path, const std::function<void(const MessageView&)>& f) const;

 private:
  MessageView(const MessageType& type, const WireCursor& cursor) : type_(&type), cursor_(cursor) {}
  /// Where the field begins. Throws BagError if there is none of this name.
  const Field& seek(std::string_view path, WireCursor* cursor) const;

  const MessageType* type_;
  WireCursor cursor_;
};

}  // namespace vir::bags
