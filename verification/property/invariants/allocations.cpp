#include "verification/property/invariants/allocations.hpp"

#include <cstdlib>
#include <new>

namespace {
long news = 0;
thread_local long mallocs = 0;
}  // namespace

#if !defined(__SANITIZE_ADDRESS__)
// glibc's own allocator, which the malloc below calls. NOLINTNEXTLINE(bugprone-reserved-identifier)
extern "C" void* __libc_malloc(std::size_t size);
extern "C" void* malloc(std::size_t size) noexcept {
  ++mallocs;
  return __libc_malloc(size);
}
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++news;
  if (void* p = std::malloc(size)) return p;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* p) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete(void* p, std::size_t) noexcept { std::free(p); }
#endif

namespace freeplay::test {

long operator_new_calls() { return news; }
long malloc_calls() { return mallocs; }

}  // namespace freeplay::test
