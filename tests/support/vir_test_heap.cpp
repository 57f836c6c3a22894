#include "vir_test_heap.h"

#include <malloc.h>

#include <atomic>
#include <cerrno>

#ifdef VIR_SANITIZED
#define VIR_HEAP_IS_OURS 0
#else
#define VIR_HEAP_IS_OURS 1
#endif

namespace {

std::atomic<long> held{0}, start{0}, peak{0};

#if VIR_HEAP_IS_OURS
void* taken(void* at) {
  if (at == nullptr) return nullptr;
  const long now = held += static_cast<long>(malloc_usable_size(at));
  long most = peak;
  while (now > most && !peak.compare_exchange_weak(most, now)) {
  }
  return at;
}
void given(void* at) {
  if (at != nullptr) held -= static_cast<long>(malloc_usable_size(at));
}
#endif

}  // namespace

#if VIR_HEAP_IS_OURS
// The program's own functions go before those of the C library, for the libraries too.
// NOLINTBEGIN(readability-identifier-naming): names of the C library.
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);

void* malloc(std::size_t size) { return taken(__libc_malloc(size)); }
void* calloc(std::size_t n, std::size_t size) { return taken(__libc_calloc(n, size)); }
void* realloc(void* at, std::size_t size) {
  const long before = at == nullptr ? 0 : static_cast<long>(malloc_usable_size(at));
  void* const now = __libc_realloc(at, size);
  if (now == nullptr && size > 0) return nullptr;  // `at` is still there
  held -= before;
  return taken(now);
}
void* memalign(std::size_t to, std::size_t size) { return taken(__libc_memalign(to, size)); }
void* aligned_alloc(std::size_t to, std::size_t size) { return memalign(to, size); }
int posix_memalign(void** at, std::size_t to, std::size_t size) {
  *at = memalign(to, size);
  return *at == nullptr ? ENOMEM : 0;
}
void free(void* at) {
  given(at);
  __libc_free(at);
}
}
// NOLINTEND(readability-identifier-naming)
#endif

namespace vir::test {

bool heapIsCounted() { return VIR_HEAP_IS_OURS != 0; }

HeapPeak::HeapPeak() {
  start = held.load();
  peak = held.load();
}

std::size_t HeapPeak::bytes() const { return static_cast<std::size_t>(peak - start); }

long HeapPeak::now() { return held - start; }

}  // namespace vir::test
