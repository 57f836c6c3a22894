/// What a rawlog asks for beyond its bound throws std::bad_alloc (libs/rawlog/src/memory_bound.h);
/// the address sanitizer's own `operator new` ends the program there. Its malloc, with all that it
/// watches, stays.
#include <cstddef>
#include <cstdlib>
#include <new>

// NOLINTBEGIN(readability-identifier-naming): names of the sanitizer and the language.
/// These here take from malloc: that new belongs to delete cannot be watched.
extern "C" const char* __asan_default_options() {
  return "allocator_may_return_null=1:alloc_dealloc_mismatch=0";
}

void* operator new(std::size_t size) {
  if (void* const at = std::malloc(size == 0 ? 1 : size)) return at;
  throw std::bad_alloc();
}
void* operator new[](std::size_t size) { return operator new(size); }
void operator delete(void* at) noexcept { std::free(at); }
void operator delete[](void* at) noexcept { std::free(at); }
void operator delete(void* at, std::size_t) noexcept { std::free(at); }
void operator delete[](void* at, std::size_t) noexcept { std::free(at); }
// NOLINTEND(readability-identifier-naming)
