#include "anchor_names.h"

#include <charconv>

namespace vir::bag {

std::uint64_t AnchorNames::numberOf(const std::string& name) {
  constexpr std::uint64_t kFirst = 1'000'000, kLargest = 0x7FFFFFFF;
  std::uint64_t number = 0;
  const bool hex = name.size() > 2 && name[0] == '0' && (name[1] == 'x' || name[1] == 'X');
  const char* begin = name.data() + (hex ? 2 : 0);
  const char* end = name.data() + name.size();
  const auto [p, error] = std::from_chars(begin, end, number, hex ? 16 : 10);
  if (error == std::errc() && p == end && number <= kLargest &&
      (number < kFirst || number >= kFirst + 100'000)) {
    return number;
  }
  return mapped_.emplace(name, kFirst + mapped_.size()).first->second;
}

}  // namespace vir::bag
