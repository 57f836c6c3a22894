#pragma once
/// How much of the heap a piece of code takes, every library of the process included. Link
/// vir_test_heap.cpp.
#include <cstddef>

namespace vir::test {

/// Is there a count? Not where a sanitizer has the heap.
bool heapIsCounted();

/// From its making on.
class HeapPeak {
 public:
  HeapPeak();
  /// The most that was held at a time beyond what was held at the beginning [byte].
  std::size_t bytes() const;
  /// What is held now beyond that; below 0: less [byte].
  static long now();
};

}  // namespace vir::test
