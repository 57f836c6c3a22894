#pragma once
/// Anchors by number: MRPT keeps 32 bits, radios have names and 64.
#include <cstdint>
#include <map>
#include <string>
#include <string_view>

namespace vir::tables {

class AnchorNames {
 public:
  /// A whole decimal number or one in 0x notation that fits stays what it is. Anything else
  /// (`200A`, 64 bits) gets a number of its own, from 1000000 on in the order in which they come.
  /// False for what is no name: empty, longer than 64 characters, not of letters, digits and
  /// `_-:.`.
  bool numberOf(std::string_view name, std::int32_t* number);
  /// As above, of whatever text a message calls an anchor; never negative.
  std::int32_t numberOfAny(std::string_view name);
  /// What got a number of its own.
  const std::map<std::string, std::int32_t>& mapped() const { return mapped_; }

 private:
  std::int32_t ownNumber(std::string_view name);

  std::map<std::string, std::int32_t> mapped_;
};

}  // namespace vir::tables
