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

}  // namespace loopstone
