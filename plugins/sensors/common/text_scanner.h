#pragma once
/// Reads a line from left to right against a grammar, without the locale. Every function returns
/// false, and moves on to nowhere useful, when the text is not exactly as asked for.
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace vir {

class TextScanner {
 public:
  explicit TextScanner(std::string_view text) : rest_(text) {}

  /// Exactly this text.
  bool literal(std::string_view text);
  bool literal(char c) { return literal(std::string_view(&c, 1)); }
  /// One of these characters.
  bool oneOf(std::string_view characters, char* which);
  /// Blanks and tabs, none too.
  void blanks();
  /// A whole decimal number, with a minus if it is negative, of at most 18 digits.
  bool integer(std::int64_t* value);
  /// Hexadecimal digits, at least `least`, at most `most` (<= 15) of them, without 0x.
  bool hex(std::size_t least, std::size_t most, std::int64_t* value);
  /// A decimal number with a point; `digits` behind it, or any number from 1 to 15 where 0 is
  /// given.
  bool fixed(std::size_t digits, double* value);
  /// Any finite number: with or without point and exponent.
  bool number(double* value);

  bool atEnd() const { return rest_.empty(); }
  /// The next characters are these; they are not taken.
  bool peek(std::string_view text) const { return rest_.substr(0, text.size()) == text; }
  std::string_view rest() const { return rest_; }

 private:
  std::size_t digitsAt(std::size_t from) const;
  bool take(std::size_t size, double* value);

  std::string_view rest_;
};

}  // namespace vir
