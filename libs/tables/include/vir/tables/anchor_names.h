#pragma once
/// Anchors by number: MRPT keeps 32 bits, radios have names and 64.
#include <cstdint>
#include <map>
#include <string>
#include <string_view>

namespace vir::tables {

/// A name from a text of unknown coding: what is no UTF-8 is taken for Latin-1.
std::string utf8Name(std::string_view text);
/// As it may stand in a file of ours or on a screen: at most 64 bytes of UTF-8 in one line.
std::string shownName(std::string_view name);

class AnchorNames {
 public:
  /// A whole decimal number or one in 0x notation that fits stays what it is. Anything else
  /// (`200A`, 64 bits) gets a number of its own, from 1000000 on in the order in which they come.
  /// False for what is no name: empty, longer than 64 bytes, not of letters (of any language),
  /// digits, blanks within (beside letters) and `_-:./#+()`.
  bool numberOf(std::string_view name, std::int32_t* number);
  /// As above, of whatever text a message calls an anchor; never negative.
  std::int32_t numberOfAny(std::string_view name);
  /// What got a number of its own.
  const std::map<std::string, std::int32_t>& mapped() const { return mapped_; }
  /// These as remarks of an ini, a line each.
  std::string remarks() const;

 private:
  std::int32_t ownNumber(std::string_view name);

  std::map<std::string, std::int32_t> mapped_;
};

}  // namespace vir::tables
