#pragma once
/// Anchors by number: MRPT keeps 32 bits, radios have names and 64.
#include <cstdint>
#include <map>
#include <string>

namespace vir::bag {

class AnchorNames {
 public:
  /// A number that fits, decimal or with 0x before it, stays what it is. Anything else gets a
  /// number of its own, from 1000000 on in the order in which they come.
  std::uint64_t numberOf(const std::string& name);
  /// What got a number of its own.
  const std::map<std::string, std::uint64_t>& mapped() const { return mapped_; }

 private:
  std::map<std::string, std::uint64_t> mapped_;
};

}  // namespace vir::bag
