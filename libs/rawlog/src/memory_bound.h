#pragma once
#include <cstdint>

namespace vir::rawlog {

/// While one lives, this process may take at most so much more memory than it has; asking for more
/// throws std::bad_alloc. MRPT takes the sizes of texts and lists as they stand in a file and
/// allocates before it reads, so that a few damaged bytes would ask for all memory there is.
/// Several may live at a time; the widest bound holds.
class MemoryBound {
 public:
  explicit MemoryBound(std::uint64_t bytes);
  ~MemoryBound();
  MemoryBound(const MemoryBound&) = delete;
  MemoryBound& operator=(const MemoryBound&) = delete;
};

}  // namespace vir::rawlog
