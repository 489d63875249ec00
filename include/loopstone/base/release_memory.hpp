#pragma once

#include <cstdlib>  // defines __GLIBC__ where it holds

#if defined(__GLIBC__)
#include <malloc.h>
#endif

namespace loopstone {

/// Gives back to the system what the allocator holds but nobody uses, where the allocator can: between two stages of work, so that
/// the second does not come on top of what the first left in pieces. Cost: about a millisecond for 100 MB.
inline void release_unused_memory() {
#if defined(__GLIBC__)
  malloc_trim(0);
#endif
}

}  // namespace loopstone
