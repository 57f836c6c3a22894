#pragma once
/// What a reader takes of the heap for one input, by the sanitizers' own count.
#include <sanitizer/allocator_interface.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdio>
#include <cstdlib>

namespace vir::fuzz {

/// Ends the program where the heap grew by more than `times` the input and a constant for buffers
/// that do not depend on it.
class MemoryWatch {
 public:
  MemoryWatch(std::size_t input, std::size_t times, std::size_t always)
      : bound_(times * input + always), input_(input) {
    static const int installed = __sanitizer_install_malloc_and_free_hooks(taken, freed);
    if (installed == 0) std::abort();
    held() = 0;
    peak() = 0;
  }
  ~MemoryWatch() {
    if (peak() <= static_cast<long>(bound_)) return;
    std::fprintf(stderr, "memory: %ld bytes for an input of %zu (at most %zu)\n", peak().load(),
                 input_, bound_);
    std::abort();
  }
  MemoryWatch(const MemoryWatch&) = delete;
  MemoryWatch& operator=(const MemoryWatch&) = delete;

 private:
  static std::atomic<long>& held() {
    static std::atomic<long> v{0};
    return v;
  }
  static std::atomic<long>& peak() {
    static std::atomic<long> v{0};
    return v;
  }
  static void taken(const volatile void*, std::size_t size) {
    const long now = held() += static_cast<long>(size);
    if (now > peak()) peak() = now;
  }
  static void freed(const volatile void* at) {
    if (at == nullptr) return;
    held() -= static_cast<long>(__sanitizer_get_allocated_size(const_cast<const void*>(at)));
  }

  std::size_t bound_, input_;
};

}  // namespace vir::fuzz
