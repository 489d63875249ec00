#include "loopstone/base/release_memory.hpp"

#include <cstdlib>  // defines __GLIBC__ where that is the library

#if defined(__GLIBC__)
#include <malloc.h>
#endif

namespace loopstone {

void release_unused_memory() {
#if defined(__GLIBC__)
  malloc_trim(0);
#endif
}

void keep_memory_compact() {
#if defined(__GLIBC__)
  constexpr int kLargeBytes = 1 << 18;
  mallopt(M_ARENA_MAX, 2);
  // Both would grow by themselves, to tens of megabytes, if they were left alone.
  mallopt(M_MMAP_THRESHOLD, kLargeBytes);
  mallopt(M_TRIM_THRESHOLD, kLargeBytes);
#endif
}

}  // namespace loopstone
