#include "loopstone/report/peak_memory.hpp"

#include <sys/resource.h>

#include <fstream>
#include <string>

namespace loopstone {

std::int64_t peak_memory_bytes() {
  constexpr std::int64_t kBytesPerKibibyte = 1024;
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    std::int64_t kibibytes = 0;
    if (word == "VmHWM:" && status >> kibibytes) return kibibytes * kBytesPerKibibyte;
  }
  // The kernel carries ru_maxrss across fork and exec, so a program started by a large one looks
  // large.
  rusage usage{};
  if (getrusage(RUSAGE_SELF, &usage) != 0) return 0;
#if defined(__APPLE__)
  return usage.ru_maxrss;
#else
  return static_cast<std::int64_t>(usage.ru_maxrss) * kBytesPerKibibyte;
#endif
}

}  // namespace loopstone
